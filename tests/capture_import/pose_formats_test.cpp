// Poses in the conventions of other programs: round trips, worked numbers, contradictions, damage.

#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "capture/import/camera_files.h"
#include "capture/import/colmap.h"
#include "capture/import/colmap_writer.h"
#include "capture/import/llff.h"
#include "capture/import/nerf.h"
#include "core/files.h"
#include "core/png.h"
#include "core/random.h"
#include "tests/error_text.h"
#include "tests/shared_data.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using testing::HasSubstr;

std::vector<ImportedView> some_views(bool centred) {
  std::vector<ImportedView> views;
  for (int i = 0; i < 3; ++i) {
    ImportedView v;
    v.name = "view_" + std::to_string(i) + ".png";
    v.intrinsics = {
        500, centred ? 500 : 510.25, 0, centred ? 319.5 : 300.1, centred ? 239.5 : 250.7, 640, 480};
    if (!centred) v.distortion = {0.1, -0.02, 1e-3, 2e-3, 0.01};
    const Eigen::Matrix3d R = (Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d(1, 2, 3).normalized()) *
                               Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX()))
                                  .toRotationMatrix() *
                              straight_R_camera_rsb();
    v.T_camera_world = {R, -(R * Eigen::Vector3d(100 + 60 * i, 130, 550))};
    views.push_back(v);
  }
  return views;
}

void expect_equal(const ImportedView& a, const ImportedView& b) {
  EXPECT_LT((a.T_camera_world.R - b.T_camera_world.R).norm(), 1e-12);
  EXPECT_LT((a.T_camera_world.t_mm - b.T_camera_world.t_mm).norm(), 1e-9);
  EXPECT_LT((a.intrinsics.K() - b.intrinsics.K()).norm(), 1e-9);
  EXPECT_EQ(a.intrinsics.width_px, b.intrinsics.width_px);
  const auto x = a.distortion.coefficients(), y = b.distortion.coefficients();
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_DOUBLE_EQ(x[i], y[i]);
  EXPECT_EQ(a.distortion.fisheye, b.distortion.fisheye);
}

constexpr PoseConvention kSix[] = {{CameraAxes::kOpenCv, false}, {CameraAxes::kOpenCv, true},
                                   {CameraAxes::kOpenGl, false}, {CameraAxes::kOpenGl, true},
                                   {CameraAxes::kLlff, false},   {CameraAxes::kLlff, true}};

TEST(PoseConvention, StatedMatricesAreWhatTheNamesSay) {
  // A camera at (1, 2, 3) that looks along the world's -z with the world's y up: OpenGL's own
  // axes, so that its camera-to-world matrix is the identity and the position.
  const RigidTransform T{
      Eigen::Vector3d(1, -1, -1).asDiagonal(),
      -(Eigen::Matrix3d(Eigen::Vector3d(1, -1, -1).asDiagonal()) * Eigen::Vector3d(1, 2, 3))};
  Eigen::Matrix<double, 3, 4> gl;
  gl << 1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3;
  EXPECT_EQ(to_stated(T, kNerfConvention), gl);
  // LLFF's columns are where down, right and backward point in the world.
  Eigen::Matrix<double, 3, 4> llff;
  llff << 0, 1, 0, 1, -1, 0, 0, 2, 0, 0, 1, 3;
  EXPECT_EQ(to_stated(T, kLlffConvention), llff);
  for (const PoseConvention c : kSix) {
    const RigidTransform back = from_stated(to_stated(T, c), c);
    EXPECT_LT((back.R - T.R).norm() + (back.t_mm - T.t_mm).norm(), 1e-14) << to_string(c);
    EXPECT_EQ(pose_convention_from_string(to_string(c)), c);
  }
  EXPECT_THAT(error_of([] { pose_convention_from_string("blender"); }),
              HasSubstr("use one of: opencv world-to-camera"));
}

TEST(PoseConvention, AContradictionNamesWhatFits) {
  const std::vector<ImportedView> truth = some_views(false);
  const std::vector<KnownPoint> points = check_points(truth, 400);
  EXPECT_EQ(points.size(), 12u);
  EXPECT_LT(require_convention("f", truth, points, kColmapConvention), 1e-9);
  for (const PoseConvention meant : kSix)
    for (const PoseConvention taken : kSix) {
      if (meant == taken) continue;
      std::vector<ImportedView> views = truth;
      for (ImportedView& v : views)
        v.T_camera_world = from_stated(to_stated(v.T_camera_world, meant), taken);
      const std::string what =
          error_of([&] { require_convention("f.json", views, points, taken); });
      EXPECT_THAT(what, HasSubstr("f.json: its poses are not " + to_string(taken)));
      EXPECT_THAT(what, HasSubstr(to_string(meant) + " fits"));
    }
  std::vector<KnownPoint> wrong = points;
  for (KnownPoint& p : wrong) p.px.x() += 100 * (p.view + 1.0);
  EXPECT_THAT(error_of([&] { require_convention("f", truth, wrong, kColmapConvention); }),
              HasSubstr("no convention fits"));
}

TEST(ColmapWriter, TextAndBinaryReadBack) {
  const TemporaryFolder folder;
  std::vector<ImportedView> views = some_views(false);
  views[1].distortion = {0.1, 0.2, 0, 0, 0.3, 0.4, 0, 0, true};
  views[2].distortion = {};
  const auto points = check_points(views, 400);
  for (const bool binary : {false, true}) {
    const auto out = folder.path / (binary ? "binary" : "text");
    write_colmap(out, binary, views, points);
    const ColmapModel m = read_colmap(out, folder.path);
    ASSERT_EQ(m.views.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) expect_equal(m.views[i], views[i]);
    EXPECT_EQ(m.points.size(), 4u);
    EXPECT_EQ(m.observations.size(), points.size());
    EXPECT_LT(median_reprojection_error_px(m), 1e-9);
  }
  views[0].intrinsics.skew_px = 1;
  EXPECT_THAT(error_of([&] { write_colmap(folder.path / "x", false, views, {}); }),
              HasSubstr("skew"));
  EXPECT_FALSE(std::filesystem::exists(folder.path / "x"));
}

TEST(ColmapWriter, LundDoorReprojectsAsColmapSaysAfterEveryWay) {
  const auto data = shared_folder("data/captured_poses/lund_door");
  REQUIRE_SHARED(data);
  const ColmapModel original = read_colmap(data / "colmap", data / "images");
  // COLMAP's own figure per point is the mean distance over the point's track.
  std::vector<double> sum(original.points.size()), count(original.points.size());
  for (const ColmapObservation& o : original.observations) {
    const ImportedView& v = original.views[o.view];
    sum[o.point] += (project(v.intrinsics, v.distortion,
                             v.T_camera_world * original.points[o.point].p_world_mm) -
                     o.pixel)
                        .norm();
    count[o.point] += 1;
  }
  double ours = 0, theirs = 0;
  std::size_t tracked = 0;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    if (count[i] == 0) continue;
    ours += sum[i] / count[i];
    theirs += original.points[i].error_px;
    ++tracked;
  }
  RecordProperty("mean_px", std::to_string(ours / static_cast<double>(tracked)));
  RecordProperty("colmap_mean_px", std::to_string(theirs / static_cast<double>(tracked)));
  EXPECT_NEAR(ours / theirs, 1, 0.01);
  const TemporaryFolder folder;
  write_colmap(folder.path, true, original.views, known_points(original));
  const ColmapModel again = read_colmap(folder.path, data / "images");
  EXPECT_NEAR(median_reprojection_error_px(again), median_reprojection_error_px(original), 1e-9);
}

TEST(Nerf, RoundTripWithItsCheckPoints) {
  const TemporaryFolder folder;
  const auto views = some_views(false);
  const auto file = folder.path / "transforms.json";
  write_nerf(file, views, check_points(views, 400));
  const NerfModel m = read_nerf(file);
  ASSERT_EQ(m.views.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) expect_equal(m.views[i], views[i]);
  EXPECT_EQ(m.convention, kNerfConvention);
  EXPECT_EQ(m.known_points.size(), 12u);
  EXPECT_LT(require_convention(file, m.views, m.known_points, m.convention), 1e-9);
  EXPECT_THAT(error_of([&] { read_nerf(file, 1, kColmapConvention); }),
              HasSubstr("says that its poses are opengl camera-to-world"));
  EXPECT_LT(
      (read_nerf(file, 10).views[1].T_camera_world.t_mm - 10 * views[1].T_camera_world.t_mm).norm(),
      1e-9);
}

// However the dataset and the file were named on the command line.
TEST(Nerf, PicturesAreNamedFromTheFile) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path / "d/views");
  write_picture_png(folder.path / "d/views/view_0.png", cv::Mat3b(480, 640));
  std::vector<ImportedView> views = {some_views(false)[0]};
  const auto relative_root = std::filesystem::relative(folder.path);
  for (const auto& picture_root : {folder.path, relative_root, folder.path / "d/.."})
    for (const auto& file_root : {folder.path, relative_root}) {
      views[0].path = picture_root / "d/views/view_0.png";
      const auto file = file_root / "out/transforms.json";
      std::filesystem::create_directories(file.parent_path());
      write_nerf(file, views, {});
      EXPECT_EQ(nlohmann::json::parse(read_text(file))["frames"][0]["file_path"],
                "../d/views/view_0.png");
      EXPECT_EQ(std::filesystem::canonical(read_nerf(file).views[0].path),
                std::filesystem::canonical(folder.path / "d/views/view_0.png"));
    }
}

TEST(Nerf, TheOriginalFormWithAnAngleAndPicturesWithoutEnding) {
  const TemporaryFolder folder;
  write_picture_png(folder.path / "r_0.png", cv::Mat3b(80, 100));
  const auto file = folder.path / "transforms_train.json";
  write_text_atomically(file, R"({"camera_angle_x": 0.5, "frames": [{"file_path": "./r_0",
    "transform_matrix": [[1,0,0,4],[0,1,0,5],[0,0,1,6],[0,0,0,1]]}]})");
  const NerfModel m = read_nerf(file);
  EXPECT_NEAR(m.views[0].intrinsics.fx_px, 50 / std::tan(0.25), 1e-9);
  EXPECT_EQ(m.views[0].intrinsics.cx_px, 49.5);
  EXPECT_EQ(m.views[0].intrinsics.cy_px, 39.5);
  EXPECT_EQ(camera_centre(m.views[0].T_camera_world), Eigen::Vector3d(4, 5, 6));
  EXPECT_TRUE(m.known_points.empty());
}

TEST(Nerf, BadValuesNameFileAndKey) {
  const TemporaryFolder folder;
  const auto file = folder.path / "transforms.json";
  const auto views = some_views(false);
  write_nerf(file, views, check_points(views, 400));
  const auto good = nlohmann::json::parse(read_text(file));
  const auto fails = [&](const nlohmann::json& j) {
    write_text_atomically(file, j.dump());
    return error_of([&] { read_nerf(file); });
  };
  auto j = good;
  j["frames"][0]["transform_matrix"][0][0] = 3;
  EXPECT_THAT(fails(j), HasSubstr("no rotation"));
  j = good;
  j["frames"][0]["fl_x"] = -1;
  EXPECT_THAT(fails(j), HasSubstr("fl_x"));
  j = good;
  j["convention"] = "mine";
  EXPECT_THAT(fails(j), HasSubstr("'mine' is no pose convention"));
  j = good;
  j["check_points"][0]["seen"][0]["frame"] = 7;
  EXPECT_THAT(fails(j), HasSubstr("not in the file"));
  j = good;
  j.erase("frames");
  EXPECT_THAT(fails(j), HasSubstr("frames"));
  EXPECT_THAT(error_of([&] { read_nerf(folder.path / "none.json"); }), HasSubstr("is missing"));
}

TEST(Llff, RoundTrip) {
  const TemporaryFolder folder;
  const auto views = some_views(true);
  write_llff(folder.path / "poses_bounds.npy", views, 190, 550);
  EXPECT_THAT(error_of([&] { read_llff(folder.path); }), HasSubstr("images"));
  make_folder(folder.path / "images");
  for (const ImportedView& v : views)
    write_picture_png(folder.path / "images" / v.name, cv::Mat3b(4, 4));
  const LlffModel m = read_llff(folder.path);
  ASSERT_EQ(m.views.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    expect_equal(m.views[i], views[i]);
    EXPECT_EQ(m.views[i].name, views[i].name);
  }
  EXPECT_EQ(m.near_mm[1], 190);
  EXPECT_EQ(m.far_mm[1], 550);
  write_picture_png(folder.path / "images/extra.png", cv::Mat3b(4, 4));
  EXPECT_THAT(error_of([&] { read_llff(folder.path); }), HasSubstr("3 poses for 4 pictures"));
}

TEST(Llff, WhatItCannotHoldIsRefused) {
  const TemporaryFolder folder;
  const auto npy = folder.path / "p.npy";
  EXPECT_THAT(error_of([&] { write_llff(npy, some_views(false), 190, 550); }),
              HasSubstr("principal point in the middle"));
  EXPECT_THAT(error_of([&] { write_llff(npy, some_views(true), 550, 190); }),
              HasSubstr("--near-mm"));
  EXPECT_FALSE(std::filesystem::exists(npy));
  write_llff(npy, some_views(true), 190, 550);
  auto bytes = read_bytes(npy);
  bytes.resize(bytes.size() - 8);
  EXPECT_THAT(error_of([&] { parse_llff(bytes, npy, {}); }), HasSubstr("shape"));
  std::string text = read_text(npy);
  text.replace(text.find("<f8"), 3, "<i8");
  EXPECT_THAT(error_of([&] { parse_llff(std::as_bytes(std::span(text)), npy, {}); }),
              HasSubstr("'<i8'"));
}

// Every outcome of damaged files is a model or a wheatstone::Error.
template <class Read>
void fuzz(const std::string& good, int iterations, std::uint64_t seed, const Read& read) {
  int models = 0, errors = 0;
  for (int i = 0; i < iterations; ++i) {
    RandomStream random(seed, static_cast<std::uint64_t>(i));
    std::string bytes = good;
    const int flips = static_cast<int>(random.next() % 4);
    for (int k = 0; k < flips; ++k)
      bytes[random.next() % bytes.size()] ^= static_cast<char>(1U << (random.next() % 8));
    if (flips == 0) bytes.resize(random.next() % bytes.size());
    try {
      read(bytes);
      ++models;
    } catch (const Error&) {
      ++errors;
    }
  }
  EXPECT_GT(errors, iterations / 20);
  EXPECT_GT(models, 0);
}

TEST(PoseFormatsFuzz, TransformsJson) {
  const TemporaryFolder folder;
  const auto views = some_views(false);
  const auto file = folder.path / "transforms.json";
  write_nerf(file, views, check_points(views, 400));
  fuzz(read_text(file), 1000, 1, [&](const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
    const NerfModel m = read_nerf(file);
    if (!m.known_points.empty()) median_error_px(m.views, m.known_points);
  });
}

TEST(PoseFormatsFuzz, PosesBoundsNpy) {
  const TemporaryFolder folder;
  const auto file = folder.path / "poses_bounds.npy";
  write_llff(file, some_views(true), 190, 550);
  fuzz(read_text(file), 3000, 2,
       [&](const std::string& bytes) { parse_llff(std::as_bytes(std::span(bytes)), file, {}); });
}

TEST(PoseFormatsFuzz, CameraFiles) {
  const TemporaryFolder folder;
  const CameraFile camera{{500.5, 510, 0, 320, 240, 640, 480}, {0.1, -0.02, 1e-3, 2e-3}};
  for (const auto& [format, name] : {std::pair(CameraFormat::kOpenCv, "c.yaml"),
                                     {CameraFormat::kColmap, "cameras.txt"},
                                     {CameraFormat::kKalibr, "k.yaml"}}) {
    const auto file = folder.path / name;
    write_camera_file(file, format, {camera});
    fuzz(read_text(file), 1000, 3, [&](const std::string& bytes) {
      std::ofstream(file, std::ios::binary) << bytes;
      read_camera_file(file);
    });
  }
}

TEST(CameraFiles, ReadBackExactly) {
  const TemporaryFolder folder;
  const Intrinsics k{500.123456789012, 510, 0, 1.0 / 3, 240, 640, 480};
  const CameraFile radtan4{k, {0.1, -0.02, 1e-3, 2e-3}};
  const CameraFile radtan8{k, {0.1, -0.02, 1e-3, 2e-3, 3, 4, 5, 6}};
  const CameraFile fisheye{k, {0.1, 0.2, 0, 0, 0.3, 0.4, 0, 0, true}};
  for (const auto format : {CameraFormat::kOpenCv, CameraFormat::kColmap, CameraFormat::kKalibr})
    for (const CameraFile& c : {radtan4, radtan8, fisheye}) {
      const auto file = folder.path / (format == CameraFormat::kColmap ? "cameras.txt" : "c.yaml");
      if (!why_not_exact(format, c).empty()) {
        EXPECT_EQ(format, CameraFormat::kKalibr);
        EXPECT_THAT(error_of([&] { write_camera_file(file, format, {c}); }), HasSubstr("radtan4"));
        continue;
      }
      write_camera_file(file, format, {c});
      const auto back = read_camera_file(file);
      ASSERT_EQ(back.size(), 1u);
      // COLMAP's half pixel is added and subtracted again.
      EXPECT_LT((back[0].intrinsics.K() - k.K()).norm(), 1e-12);
      EXPECT_EQ(back[0].intrinsics.height_px, 480);
      EXPECT_EQ(back[0].distortion.coefficients(), c.distortion.coefficients());
      EXPECT_EQ(back[0].distortion.fisheye, c.distortion.fisheye);
    }
  const auto camchain = folder.path / "camchain.yaml";
  write_camera_file(camchain, CameraFormat::kKalibr, {radtan4, fisheye},
                    RigidTransform{Eigen::Matrix3d::Identity(), {-120, 0, 0}});
  EXPECT_EQ(read_camera_file(camchain).size(), 2u);
  EXPECT_THAT(read_text(camchain), HasSubstr("[1.0, 0.0, 0.0, -0.12]"));
}

TEST(CameraFiles, FilesOfTheOtherPrograms) {
  const TemporaryFolder folder;
  const auto file = folder.path / "camchain.yaml";
  write_text_atomically(
      file,
      "cam0:\n  T_cam_imu:\n  - [0.01, -0.99, 0.004, -0.02]\n  - [0.99, 0.01, 0.02, -0.06]\n"
      "  - [-0.02, 0.003, 0.99, 0.009]\n  - [0.0, 0.0, 0.0, 1.0]\n"
      "  cam_overlaps: []\n  camera_model: pinhole\n"
      "  distortion_coeffs: [-0.29, 0.08, 0.0002, -1.5e-05]\n"
      "  distortion_model: radtan\n  intrinsics: [461.1, 459.2, 362.6, 248.5]\n"
      "  resolution: [752, 480]\n  rostopic: /cam0/image_raw\n");
  EXPECT_EQ(read_camera_file(file)[0].distortion.p2, -1.5e-05);
  EXPECT_EQ(read_camera_file(file)[0].intrinsics.width_px, 752);
  const auto opencv = shared_folder("data/camera_calibration/opencv_9x6/left_intrinsics.yml");
  REQUIRE_SHARED(opencv);
  const auto left = read_camera_file(opencv);
  EXPECT_NEAR(left[0].intrinsics.fx_px, 535.91573396163199, 1e-10);
  EXPECT_NEAR(left[0].distortion.k3, 0.238391530808785, 1e-12);
  write_text_atomically(file, "cam0:\n  camera_model: omni\n");
  EXPECT_THAT(error_of([&] { read_camera_file(file); }), HasSubstr("camera model omni"));
  write_text_atomically(file, "nothing: 1\n");
  EXPECT_THAT(error_of([&] { read_camera_file(file); }), HasSubstr("neither"));
}

}  // namespace
}  // namespace wheatstone
