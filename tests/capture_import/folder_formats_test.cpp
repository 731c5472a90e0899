// Light-field folders, pose lists and stereo EXR.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "capture/import/light_field_renderer.h"
#include "capture/import/poses_json.h"
#include "capture/import/stereo_rgbd.h"
#include "core/error.h"
#include "core/files.h"
#include "core/png.h"
#include "tests/shared_data.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

template <class F>
std::string failure(F f) {
  try {
    f();
  } catch (const FileError& e) {
    return e.what();
  }
  return "no FileError";
}

TEST(LightFieldFolder, PositionsComeFromTheNames) {
  const TemporaryFolder folder;
  write_picture_png(folder.path / "my_scene_02_03_-61.5_30.25_30_36.png", cv::Mat3b(6, 8));
  write_picture_png(folder.path / "unrelated.png", cv::Mat3b(6, 8));
  const auto views = read_light_field_folder(folder.path);
  ASSERT_EQ(views.size(), 1u);
  const auto& v = views[0];
  EXPECT_EQ(camera_centre(v.T_camera_world), Eigen::Vector3d(30.25, 61.5, 0));
  EXPECT_EQ(v.intrinsics.width_px, 8);
  EXPECT_DOUBLE_EQ(v.intrinsics.fx_px, 30.0 / 36 * 8);
  EXPECT_EQ(v.intrinsics.cx_px, 3.5);
  EXPECT_EQ(v.intrinsics.cy_px, 2.5);
  EXPECT_EQ(load_view(v, 100).light_cd_m2.width(), 8);
  // Right and up of the axis in front of the camera: right and up in the picture.
  const Eigen::Vector2d pixel =
      project(v.intrinsics, v.distortion, v.T_camera_world * Eigen::Vector3d(31.25, 62.5, -10));
  EXPECT_GT(pixel.x(), 3.5);
  EXPECT_LT(pixel.y(), 2.5);
}

TEST(LightFieldFolder, DamageIsReported) {
  const TemporaryFolder folder;
  EXPECT_THROW(read_light_field_folder(folder.path), FileError);
  EXPECT_THROW(read_light_field_folder(folder.path / "none"), FileError);
  write_text_atomically(folder.path / "s_00_00_0_0_30_36.jpg", "\xff\xd8\xff\xe0");
  EXPECT_THROW(read_light_field_folder(folder.path), FileError);
  std::filesystem::remove(folder.path / "s_00_00_0_0_30_36.jpg");
  write_picture_png(folder.path / "s_00_00_1.2.3_0_30_36.png", cv::Mat3b(6, 8));
  EXPECT_THROW(read_light_field_folder(folder.path), FileError);
}

TEST(LightFieldFolder, Shop) {
  const auto folder = shared_folder("data/lightfield_shop");
  REQUIRE_SHARED(folder);
  const auto views = read_light_field_folder(folder);
  ASSERT_EQ(views.size(), 69u);
  for (const auto& v : views) {
    EXPECT_DOUBLE_EQ(v.intrinsics.fx_px, 800);
    EXPECT_EQ(v.intrinsics.width_px, 960);
    EXPECT_EQ(v.intrinsics.height_px, 640);
    if (v.name.starts_with("shop_13_00_")) {
      EXPECT_NEAR(camera_centre(v.T_camera_world).x(), 400, 1e-9);
    }
    if (v.name.starts_with("shop_07_07_")) {
      EXPECT_NEAR(camera_centre(v.T_camera_world).y(), -184.615385, 1e-9);
    }
  }
}

TEST(PosesJson, RoundTrip) {
  const TemporaryFolder folder;
  write_picture_png(folder.path / "a.png", cv::Mat3b(6, 8));
  ImportedView v;
  v.name = "a";
  v.path = folder.path / "a.png";
  v.intrinsics = {500.1, 501.2, 0.1, 3.4, 2.6, 8, 6};
  v.distortion = {0.1, -0.2, 1e-3, 2e-3, 0.01};
  v.T_camera_world.R =
      Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  v.T_camera_world.t_mm = {1.5, -2.25, 1.0 / 3};
  ImportedView absent = v;
  absent.path.clear();
  absent.distortion = {};
  write_poses_json(folder.path / "poses.json", std::vector<ImportedView>{v, absent});
  const auto back = read_poses_json(folder.path / "poses.json");
  ASSERT_EQ(back.size(), 2u);
  EXPECT_EQ(back[0].path, v.path);
  EXPECT_TRUE(back[1].path.empty());
  EXPECT_EQ(back[0].T_camera_world.R, v.T_camera_world.R);
  EXPECT_EQ(back[0].T_camera_world.t_mm, v.T_camera_world.t_mm);
  EXPECT_EQ(back[0].intrinsics.K(), v.intrinsics.K());
  EXPECT_EQ(back[0].distortion.k3, 0.01);
  EXPECT_TRUE(back[1].distortion.is_zero());
}

TEST(PosesJson, ConventionAndValuesAreChecked) {
  const TemporaryFolder folder;
  const auto path = folder.path / "poses.json";
  ImportedView v;
  v.intrinsics = {500, 500, 0, 4, 3, 8, 6};
  write_poses_json(path, std::vector<ImportedView>{v});
  const auto good = nlohmann::json::parse(read_text(path));
  const auto fails = [&](const nlohmann::json& j) {
    write_text_atomically(path, j.dump());
    return failure([&] { read_poses_json(path); });
  };
  auto j = good;
  j.erase("convention");
  EXPECT_THAT(fails(j), testing::HasSubstr(kPoseConvention));
  j["convention"] = "OpenGL";
  EXPECT_THAT(fails(j), testing::HasSubstr(kPoseConvention));
  j["convention"] = 3;
  EXPECT_THAT(fails(j), testing::HasSubstr(kPoseConvention));
  j = good;
  j["views"][0]["R"][0][0] = -1;
  EXPECT_THAT(fails(j), testing::HasSubstr("not a rotation"));
  j = good;
  j["views"][0]["K"]["fx_px"] = 0;
  EXPECT_THAT(fails(j), testing::HasSubstr("focal length"));
  j = good;
  j["views"][0].erase("t_mm");
  EXPECT_THAT(fails(j), testing::HasSubstr("t_mm"));
  j = good;
  j["views"][0]["size"] = {8};
  EXPECT_THAT(fails(j), testing::HasSubstr("size"));
}

ExrView exr_view(const std::string& name) {
  ExrView v{name, {}, 3, 2};
  for (const char* c : {"R", "G", "B", "A"}) v.channels[c] = ScalarImage(3, 2, 0.5f);
  v.channels["Z"] = ScalarImage(3, 2, name == "left" ? 9.0f : 10.0f);
  return v;
}

TEST(StereoRgbd, ViewsAndChannels) {
  std::vector<ExrView> views = {exr_view("right"), exr_view("left")};
  views[1].channels["A"].pixels(1, 2) = 0;
  views[1].channels["Z"].pixels(0, 0) = 0;
  const StereoRgbd s = stereo_rgbd(views, "x.exr");
  EXPECT_EQ(s.left.z_units.pixels(1, 1), 9);
  EXPECT_EQ(s.right.z_units.pixels(1, 1), 10);
  EXPECT_EQ(cv::countNonZero(s.left.mask), 4);
  EXPECT_EQ(cv::countNonZero(s.right.mask), 6);
  views[0].channels.erase("Z");
  EXPECT_THAT(failure([&] { stereo_rgbd(views, "x.exr"); }),
              testing::HasSubstr("view 'right' has no channel Z"));
  views.erase(views.begin());
  EXPECT_THAT(failure([&] { stereo_rgbd(views, "x.exr"); }), testing::HasSubstr("no view 'right'"));
}

TEST(StereoRgbd, BeachballDepthsMatchDisparity) {
  const auto file = shared_folder("data/openexr_stereo/beachball/singlepart.0001.exr");
  REQUIRE_SHARED(file);
  const auto views = read_exr_views(file);
  const StereoRgbd s = stereo_rgbd(views, file);
  EXPECT_EQ(s.left.light.width(), 2048);
  EXPECT_EQ(s.right.light.height(), 1556);
  // The ball's centre: right(x) = left(x + 333.32 / Z) (see the data set's notes).
  const float z = s.right.z_units.pixels(683, 1092);
  EXPECT_GT(z, 8.9f);
  EXPECT_LT(z, 10.0f);
  EXPECT_TRUE(s.right.mask(683, 1092));
  const int shift = static_cast<int>(std::lround(333.32 / z));
  EXPECT_TRUE(s.left.mask(683, 1092 + shift));
  EXPECT_NEAR(s.left.z_units.pixels(683, 1092 + shift), z, 0.01);
  const auto fog = shared_folder("data/openexr_stereo/multiview/Fog.exr");
  EXPECT_THAT(failure([&] { stereo_rgbd(read_exr_views(fog), fog); }),
              testing::HasSubstr("has no channel R"));
}

}  // namespace
}  // namespace wheatstone
