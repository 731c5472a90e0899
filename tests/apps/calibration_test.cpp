// Camera calibration, poses and their formats through the program: what scripts rely on, and what
// the program says to input it cannot use.
#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/exr.h"
#include "core/files.h"
#include "core/json.h"
#include "core/png.h"
#include "program.h"
#include "sim/simulated_rig.h"
#include "tests/shared_data.h"

namespace wheatstone::apps {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kWidth = 320, kHeight = 240;

/// A board of 6x4 inner corners, 25 mm, before a camera of f = 300 px, as an anti-aliased picture.
cv::Mat3b photograph(const Eigen::Vector3d& turn_rad, const Eigen::Vector3d& centre_mm,
                     int width = kWidth) {
  const double angle = std::max(1e-12, turn_rad.norm());
  const Eigen::Matrix3d R = Eigen::AngleAxisd(angle, turn_rad / angle).toRotationMatrix();
  cv::Mat3b picture(kHeight, width);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < width; ++x) {
      double light = 0;
      for (int s = 0; s < 16; ++s) {
        const Eigen::Vector3d ray((x + (s % 4 - 1.5) / 4 - 159.5) / 300,
                                  (y + (s / 4 - 1.5) / 4 - 119.5) / 300, 1);
        // p = ray * d lies on the board: its z in the board's frame is 0.
        const double d = R.col(2).dot(centre_mm) / R.col(2).dot(ray);
        const Eigen::Vector3d on_board = R.transpose() * (ray * d - centre_mm);
        const double u = on_board.x() / 25 + 3.5, v = on_board.y() / 25 + 2.5;
        const bool inside = u > 0 && v > 0 && u < 7 && v < 5;
        light += inside && (int(u) + int(v)) % 2 == 0 ? 30 : 220;
      }
      picture(y, x) = cv::Vec3b::all(static_cast<unsigned char>(light / 16));
    }
  return picture;
}

class Calibration : public TemporaryFolder {
 protected:
  void write_boards(int count, double tilt_rad = 0.5) {
    fs::create_directories(root_ / "pictures");
    for (int i = 0; i < count; ++i) {
      const double a = 1.3 * i;
      write_picture_png(root_ / ("pictures/board_" + std::to_string(i) + ".png"),
                        photograph(tilt_rad * Eigen::Vector3d(std::cos(a), std::sin(a), 0),
                                   {12 * std::cos(2 * a), 9 * std::sin(2 * a), 270 + 6.0 * i}));
    }
  }
  Outcome calibrate(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {"calibrate",      "camera",      "--images",
                                          path("pictures"), "--square-mm", "25"};
    if (std::find(more.begin(), more.end(), "--board") == more.end())
      more.insert(more.end(), {"--board", "6x4"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }
};

TEST_F(Calibration, JsonHasWhatScriptsReadAndTheFilesAreThere) {
  write_boards(7);
  write_picture_png(root_ / "pictures/empty.png", cv::Mat3b(kHeight, kWidth, cv::Vec3b(9, 9, 9)));
  const Outcome outcome = calibrate({"--json", "--distortion", "radtan4", "--out", path("out")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json c = json::parse(outcome.out);
  EXPECT_NEAR(c["fx_px"].get<double>(), 300, 4 * c["fx_px_sigma"].get<double>() + 0.5);
  EXPECT_NEAR(c["cy_px"].get<double>(), 119.5, 4 * c["cy_px_sigma"].get<double>() + 0.5);
  for (const char* key : {"fy_px", "cx_px", "fy_px_sigma", "cx_px_sigma", "rms_px"})
    EXPECT_TRUE(c[key].is_number()) << key;
  EXPECT_EQ(c["distortion"].size(), 4u);
  EXPECT_EQ(c["distortion_sigma"].size(), 4u);
  EXPECT_LT(c["rms_px"].get<double>(), 0.2);
  EXPECT_GT(c["cross_validation_rms_px"].get<double>(), 0);
  EXPECT_EQ(c["boards"].size(), 7u);
  EXPECT_EQ(c["pictures_without_board"][0], "empty.png");
  EXPECT_THAT(c["advice"].get<std::string>(), HasSubstr("hold the board"));
  for (const char* file : {"camera.yaml", "cameras.txt", "camchain.yaml", "coverage.png",
                           "uncertainty.png", "uncertainty.exr", "calibration.json"})
    EXPECT_TRUE(fs::exists(root_ / "out" / file)) << file;
  EXPECT_EQ(read_exr_views(root_ / "out/uncertainty.exr")[0].channels.at("sigma_px").width(),
            kWidth);
  EXPECT_EQ(run_program({"convert-camera", path("out/camera.yaml"), "--format", "kalibr", "--out",
                         path("again.yaml")})
                .status,
            0);
  EXPECT_EQ(read_text(path("again.yaml")), read_text(path("out/camchain.yaml")));
  expect_refused(run_program({"convert-camera", path("out/camera.yaml"), "--format", "colmap",
                              "--out", path("out/camera.yaml")}),
                 {"is read from, and would be overwritten"});
  EXPECT_THAT(calibrate().out, HasSubstr("projection uncertainty"));
  expect_refused(run_program({"convert-camera", path("out/calibration.json"), "--format", "colmap",
                              "--out", path("again.txt")}),
                 {path("out/calibration.json"), "is JSON", "OpenCV or Kalibr .yaml"});
  EXPECT_TRUE(c["loose_coefficients"].empty());
  // Eight terms for a lens without distortion: they make up for each other, and Ceres is silent.
  const Outcome rational = calibrate({"--distortion", "radtan8"});
  EXPECT_EQ(rational.status, 0) << rational.err;
  EXPECT_THAT(rational.out, HasSubstr("not determined one by one: k"));
  EXPECT_THAT(rational.err, Not(HasSubstr("solver failure")));
}

TEST_F(Calibration, BadPicturesAndArguments) {
  expect_refused(calibrate(), {path("pictures"), "cannot be listed"});
  fs::create_directories(root_ / "pictures");
  expect_refused(calibrate(), {path("pictures"), "holds no picture"});
  write_boards(2);
  expect_refused(calibrate(), {"3 pictures, not 2", "at least 10"});
  expect_refused(calibrate({"--board", "9x6"}),
                 {"no board of 9x6 inner corners in 2 pictures", "count the inner corners"});
  expect_refused(calibrate({"--board", "six"}), {"'six' is no chessboard", "as in 9x6"});
  expect_refused(calibrate({"--distortion", "poly3"}),
                 {"'poly3' is no distortion model", "radtan5"});
  expect_refused(calibrate({"--match", "left*"}), {"matches 'left*'"});
  write_picture_png(root_ / "pictures/board_9.png", photograph({0, 0.1, 0}, {0, 0, 280}, 330));
  expect_refused(calibrate({"--out", path("out")}),
                 {path("pictures/board_9.png"), "330x240", "board_0.png is 320x240", "--match"});
  fs::resize_file(root_ / "pictures/board_9.png", 700);
  expect_refused(calibrate({"--out", path("out")}), {path("pictures/board_9.png"), "damaged"});
  EXPECT_FALSE(fs::exists(root_ / "out"));
}

TEST_F(Calibration, SquaresInMetresAreWarnedOf) {
  write_boards(3);
  const auto with = [&](const std::string& square_mm) {
    return run_program({"calibrate", "camera", "--images", path("pictures"), "--board", "6x4",
                        "--square-mm", square_mm, "--distortion", "radtan4"})
        .err;
  };
  EXPECT_THAT(with("0.025"), HasSubstr("takes millimetres"));
  EXPECT_THAT(with("25"), Not(HasSubstr("millimetres")));
}

// OpenCV's pictures of a board of 9x6, told to be of 8x6: the same camera, with a warning.
TEST_F(Calibration, APartOfTheBoardIsWarnedOf) {
  const auto photos = shared_folder("data/camera_calibration/opencv_9x6");
  REQUIRE_SHARED(photos);
  const auto as = [&](const std::string& board) {
    return run_program({"calibrate", "camera", "--images", photos.string(), "--match", "left*",
                        "--board", board, "--square-mm", "25", "--json"});
  };
  const Outcome whole = as("9x6"), part = as("8x6");
  ASSERT_EQ(whole.status, 0) << whole.err;
  ASSERT_EQ(part.status, 0) << part.err;
  EXPECT_THAT(whole.err, Not(HasSubstr("warning")));
  EXPECT_THAT(part.err,
              HasSubstr("7 pictures the chessboard goes on beyond the 8x6 inner corners"));
  const json a = json::parse(whole.out), b = json::parse(part.out);
  EXPECT_TRUE(a["larger_board"].empty());
  EXPECT_EQ(b["larger_board"].size(), 7u);
  for (const char* key : {"fx_px", "fy_px", "cx_px", "cy_px"}) {
    const std::string sigma = std::string(key) + "_sigma";
    EXPECT_NEAR(a[key].get<double>(), b[key].get<double>(),
                3 * std::hypot(a[sigma].get<double>(), b[sigma].get<double>()))
        << key;
  }
}

TEST_F(Calibration, ParallelBoardsDetermineNoFocalLength) {
  write_boards(5, 1e-4);
  expect_refused(calibrate({"--out", path("out")}),
                 {"focal length is not determined", "tilted by 30 to 45 degrees"});
  EXPECT_FALSE(fs::exists(root_ / "out"));
}

TEST_F(Calibration, TruncatedJpegIsDamaged) {
  const auto photo = shared_folder("data/camera_calibration/opencv_9x6/left01.jpg");
  REQUIRE_SHARED(photo);
  fs::create_directories(root_ / "pictures");
  fs::copy_file(photo, root_ / "pictures/left01.jpg");
  fs::resize_file(root_ / "pictures/left01.jpg", fs::file_size(photo) / 2);
  expect_refused(calibrate({"--board", "9x6"}), {path("pictures/left01.jpg"), "ends early"});
}

TEST_F(Calibration, StereoPairs) {
  fs::create_directories(root_ / "pictures");
  for (int i = 0; i < 5; ++i)
    for (const double eye : {0.0, 30.0}) {
      const double a = 1.3 * i;
      write_picture_png(
          root_ /
              ("pictures/" + std::string(eye == 0 ? "left" : "right") + std::to_string(i) + ".png"),
          photograph(0.5 * Eigen::Vector3d(std::cos(a), std::sin(a), 0),
                     {12 * std::cos(2 * a) + 15 - eye, 9 * std::sin(2 * a), 270 + 6.0 * i}));
    }
  const std::vector<std::string> command = {
      "calibrate",   "stereo",       "--images", path("pictures"), "--board",  "6x4",
      "--square-mm", "25",           "--left",   "left*",          "--right",  "right*",
      "--json",      "--distortion", "radtan4",  "--out",          path("out")};
  const Outcome outcome = run_program(command);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json s = json::parse(outcome.out);
  EXPECT_NEAR(s["baseline_mm"].get<double>(), 30, 4 * s["baseline_mm_sigma"].get<double>() + 0.05);
  EXPECT_EQ(s["pairs"].size(), 5u);
  EXPECT_TRUE(fs::exists(root_ / "out/camchain.yaml"));
  EXPECT_TRUE(s["unpaired"].empty());
  const cv::Mat3b empty(kHeight, kWidth, cv::Vec3b(9, 9, 9));
  fs::copy_file(path("pictures/left0.png"), path("pictures/left7.png"));
  fs::copy_file(path("pictures/left0.png"), path("pictures/left8.png"));
  write_picture_png(path("pictures/right8.png"), empty);
  write_picture_png(path("pictures/left9.png"), empty);
  std::vector<std::string> in_words = command;
  std::erase(in_words, "--json");
  const std::string words = run_program(in_words).out;
  for (const char* line : {"without its other half: left7.png (the other side has no picture 7)",
                           "without its other half: left8.png (no board in right8.png)",
                           "without its other half: left9.png (no board in it)"})
    EXPECT_THAT(words, HasSubstr(line));
  std::vector<std::string> alike = command;
  std::replace(alike.begin(), alike.end(), std::string("right*"), std::string("left*"));
  expect_refused(run_program(alike),
                 {path("pictures/left0.png"), "left and of the right camera", "--right"});
  for (int i = 0; i < 3; ++i) fs::remove(root_ / ("pictures/right" + std::to_string(i) + ".png"));
  expect_refused(run_program(command), {path("pictures"), "2 pairs; 3 are needed"});
}

/// A capture of markers alone, three views at a tenth of the pixels, with merged views that are
/// blank: poses need no more.
void write_marker_capture(const Dataset& dataset, int dark_marker_in_view_1 = -1) {
  SimulatedRig twin({"card", 0.1, 7});
  const Rig rig = twin.rig();
  for (const char* folder : {"raw", "hdr"}) fs::create_directories(dataset.file(folder));
  dataset.write_camera(rig.camera_profile);
  dataset.write_landmarks({rig.marker_positions_rsb_mm, rig.near_cross_positions_rsb_mm});
  rig.stage->home(rig.clock.in(60.0_s));
  rig.leds->set_all(0, rig.clock.in(60.0_s));
  std::vector<CapturedView> views;
  for (int i = 0; i < 4; ++i) {
    const std::string name = "view_00" + std::to_string(i);
    const double at_mm = 50.0 + 20 * i;
    const double reached_mm = rig.stage->move_to(Length::of(at_mm), rig.clock.in(60.0_s)).value();
    const bool all_lit = i != 1 || dark_marker_in_view_1 < 0;
    rig.markers->set(
        all_lit ? rig.markers->all() : rig.markers->all() & ~(1U << dark_marker_in_view_1),
        rig.clock.in(60.0_s));
    const ExposureRecord frame{"raw/" + name + "_markers.png", 1 / 60.0};
    write_mosaic_png(dataset.file(frame.file),
                     rig.camera->expose(Duration::of(1 / 60.0), rig.clock.in(60.0_s)).mosaic);
    write_exr(
        dataset.file("hdr/" + name + ".exr"),
        RgbImage(rig.camera_profile.intrinsics.width_px, rig.camera_profile.intrinsics.height_px));
    views.push_back({name, at_mm, reached_mm, {frame}, frame});
  }
  dataset.write_frames(views);
  dataset.write_manifest({"capture", "card", 7, 0.1, "test", 0, 1});
}

TEST_F(Calibration, PosesWithTheirReport) {
  write_marker_capture(Dataset(root_ / "d"));
  const Outcome outcome = run_program({"calibrate", "poses", path("d")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("rail: straight to"));
  // Spots of two pixels at a tenth of the size: the noise of their light explains the least part.
  EXPECT_THAT(outcome.out, HasSubstr("noise factor"));
  EXPECT_THAT(outcome.err, HasSubstr("too few pixels wide for these standard deviations"));
  const json report = read_json(path("d/pose_report.json"), "wheatstone-pose-report/1");
  EXPECT_NEAR(report["rail"]["pitch_mm"].get<double>(), 20, 0.1);
  EXPECT_LT(report["rail"]["step_error_largest_mm"].get<double>(), 0.2);
  ASSERT_EQ(report["views"].size(), 4u);
  EXPECT_EQ(report["views"][0]["covariance_rad_mm"].size(), 6u);
  EXPECT_GT(report["views"][0]["near_plane_sigma_px"].get<double>(), 0);
  EXPECT_EQ(report["views"][3]["off_line_mm"].size(), 3u);
  EXPECT_THAT(read_text(path("d/rail.svg")), HasSubstr("position on the rail (mm)"));
  EXPECT_EQ(run_program({"calibrate", "poses", path("d"), "--no-rail-prior"}).status, 0);
}

TEST_F(Calibration, ABadViewIsNamedOrLeftOut) {
  write_marker_capture(Dataset(root_ / "d"), 2);
  expect_refused(run_program({"calibrate", "poses", path("d")}),
                 {"bad view view_001", path("d/raw/view_001_markers.png"), "found 3 of 4",
                  "--skip-bad-views"});
  EXPECT_FALSE(fs::exists(path("d/poses.json")));
  const Outcome outcome = run_program({"calibrate", "poses", path("d"), "--skip-bad-views"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("left out view_001"));
  EXPECT_EQ(read_json(path("d/pose_report.json"), "wheatstone-pose-report/1")["views"].size(), 3u);
}

TEST_F(Calibration, AViewThatIsNotWhereTheRailPutItIsNamedOrLeftOut) {
  const Dataset dataset(root_ / "d");
  write_marker_capture(dataset);
  fs::copy_file(path("d/raw/view_000_markers.png"), path("d/raw/view_003_markers.png"),
                fs::copy_options::overwrite_existing);
  expect_refused(run_program({"calibrate", "poses", path("d")}),
                 {"bad view view_003", "mm on the rail, which reported 1", "--skip-bad-views"});
  EXPECT_FALSE(fs::exists(path("d/poses.json")));
  const Outcome outcome = run_program({"calibrate", "poses", path("d"), "--skip-bad-views"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("left out view_003: its markers put it at "));
  const json report = read_json(path("d/pose_report.json"), "wheatstone-pose-report/1");
  EXPECT_LT(report["rail"]["step_error_largest_mm"].get<double>(), 0.2);

  // A rail whose scale and zero are off is no view's fault.
  write_marker_capture(Dataset(root_ / "e"));
  std::vector<CapturedView> views = Dataset(root_ / "e").read_frames();
  for (CapturedView& v : views) v.reached_mm = 300 + 0.9 * v.reached_mm;
  Dataset(root_ / "e").write_frames(views);
  EXPECT_EQ(run_program({"calibrate", "poses", path("e")}).status, 0);
}

TEST_F(Calibration, SwappedLedsAreNamed) {
  const Dataset dataset(root_ / "d");
  write_marker_capture(dataset);
  Dataset::Landmarks landmarks = dataset.read_landmarks();
  std::swap(landmarks.markers_mm[0], landmarks.markers_mm[2]);
  dataset.write_landmarks(landmarks);
  expect_refused(run_program({"calibrate", "poses", path("d")}),
                 {"view_000, view_001", "the bottom-left and top-left LEDs are swapped"});
}

TEST_F(Calibration, ExportedPosesComeBackAndAWrongConventionIsRefused) {
  write_small_light_field(root_ / "d");
  const json views = read_json(path("d/views.json"), "wheatstone-poses/1");
  for (const std::string format : {"colmap-text", "colmap-binary", "nerf"}) {
    const std::string out = path(format);
    ASSERT_EQ(run_program({"export-poses", path("d"), "--format", format, "--out", out}).status, 0);
    expect_refused(run_program({"export-poses", path("d"), "--format", format, "--out", out}),
                   {out, "is not empty"});
  }
  // Pictures for the importer under the names that the poses use.
  for (int i = 0; i < 3; ++i)
    write_picture_png(root_ / ("nerf/view_" + std::to_string(i) + ".png"),
                      cv::Mat3b(36, 48, cv::Vec3b(9, 9, 9)));
  json transforms = json::parse(read_text(path("nerf/transforms.json")));
  for (int i = 0; i < 3; ++i)
    transforms["frames"][i]["file_path"] = "view_" + std::to_string(i) + ".png";
  std::ofstream(path("nerf/transforms.json")) << transforms.dump();
  const Outcome outcome = run_program({"import", path("nerf"), "--out", path("back")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("opengl camera-to-world, median reprojection error 0.00 px"));
  const json back = read_json(path("back/views.json"), "wheatstone-poses/1");
  for (int i = 0; i < 3; ++i)
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(back["views"][i]["t_mm"][axis].get<double>(),
                  views["views"][i]["t_mm"][axis].get<double>(), 1e-9);

  transforms["convention"] = "opencv camera-to-world";
  std::ofstream(path("nerf/transforms.json")) << transforms.dump();
  expect_refused(
      run_program({"import", path("nerf"), "--out", path("wrong")}),
      {path("nerf/transforms.json"), "not opencv camera-to-world", "opengl camera-to-world fits"});
  EXPECT_FALSE(fs::exists(path("wrong/dataset.json")));
  expect_refused(run_program({"import", path("nerf"), "--out", path("wrong"), "--convention", "x"}),
                 {"'x' is no pose convention"});
  expect_refused(run_program({"export-poses", path("d"), "--format", "llff", "--near-mm", "9",
                              "--far-mm", "3", "--out", path("llff")}),
                 {"0 < near < far"});
}

TEST_F(Calibration, ExportsNameThePicturesOfADatasetGivenByARelativePath) {
  write_small_light_field(root_ / "d");
  fs::copy_file(path("d/views.json"), path("d/poses.json"));
  const std::string dataset = fs::relative(root_ / "d").string();
  for (const std::string source : {"views.json", "poses.json"}) {
    const auto with = [&](const std::string& format) {
      std::vector<std::string> arguments = {"export-poses", dataset, "--format",
                                            format,         "--out", path(format + source)};
      if (source == "poses.json") arguments.emplace_back("--distorted");
      const Outcome outcome = run_program(arguments);
      EXPECT_EQ(outcome.status, 0) << outcome.err;
      return root_ / (format + source);
    };
    const fs::path nerf = with("nerf"), colmap = with("colmap-text");
    const json frames = json::parse(read_text(nerf / "transforms.json"))["frames"];
    ASSERT_EQ(frames.size(), 3u);
    for (const json& frame : frames) {
      EXPECT_TRUE(fs::is_regular_file(nerf / frame["file_path"].get<std::string>())) << frame;
      const std::string name = fs::path(frame["file_path"].get<std::string>()).filename();
      EXPECT_THAT(read_text(colmap / "images.txt"), HasSubstr(" " + name + "\n"));
    }
  }
}

TEST_F(Calibration, LundDoorIsVerifiedWhenImported) {
  const auto folder = shared_folder("data/captured_poses/lund_door");
  REQUIRE_SHARED(folder);
  // With camera-to-world poses in images.txt: every centre where the translation should be.
  fs::create_directories(root_ / "door/colmap");
  for (const char* file : {"cameras.txt", "points3D.txt"})
    fs::copy_file(folder / "colmap" / file, root_ / "door/colmap" / file);
  std::ifstream in(folder / "colmap/images.txt");
  std::ofstream out(path("door/colmap/images.txt"));
  bool pose = true;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("#")) continue;
    if (pose) {
      std::istringstream words(line);
      double id, w, x, y, z;
      Eigen::Vector3d t;
      words >> id >> w >> x >> y >> z >> t[0] >> t[1] >> t[2];
      const Eigen::Quaterniond q(w, x, y, z);
      const Eigen::Vector3d c = -(q.conjugate() * t);
      std::string rest;
      std::getline(words, rest);
      out.precision(17);
      out << id << ' ' << w << ' ' << -x << ' ' << -y << ' ' << -z << ' ' << c[0] << ' ' << c[1]
          << ' ' << c[2] << rest << '\n';
    } else {
      out << line << '\n';
    }
    pose = !pose;
  }
  out.close();
  expect_refused(
      run_program({"import", path("door"), "--out", path("wrong")}),
      {path("door/colmap"), "not opencv world-to-camera", "opencv camera-to-world fits"});
}

}  // namespace
}  // namespace wheatstone::apps
