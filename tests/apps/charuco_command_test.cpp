// `wheatstone calibrate camera --charuco` on pictures of a known camera.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "core/png.h"
#include "program.h"
#include "tests/calib/synthetic_charuco.h"

namespace wheatstone::apps {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

class CharucoCommand : public TemporaryFolder {
 protected:
  void write_picture(const std::string& name, const cv::Mat1b& grey) const {
    cv::Mat3b rgb;
    cv::cvtColor(grey, rgb, cv::COLOR_GRAY2RGB);
    fs::create_directories(root_ / "pictures");
    write_picture_png(root_ / "pictures" / name, rgb);
  }
  Outcome calibrate(std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"calibrate",   "camera", "--images", path("pictures"),
                                          "--square-mm", "25",     "--board",  "7x5"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }
  const SyntheticCamera camera_;
};

TEST_F(CharucoCommand, GivesTheCameraAndSaysWhichBoard) {
  RandomStream random(3, 1);
  for (int i = 0; i < 7; ++i)
    write_picture("board_" + std::to_string(i) + ".png",
                  photograph(camera_, random_board(camera_, kCharucoBoard, 0.7, random)));
  cv::Mat1b hidden = photograph(camera_, random_board(camera_, kCharucoBoard, 0.1, random));
  cv::rectangle(hidden, {0, 0, hidden.cols, hidden.rows}, 120, cv::FILLED);
  write_picture("hidden.png", hidden);
  const Outcome outcome = calibrate(
      {"--charuco", "DICT_4X4_50", "--marker-mm", "18", "--json", "--distortion", "radtan4"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json c = json::parse(outcome.out);
  for (const auto& [key, truth] : {std::pair("fx_px", camera_.k.fx_px),
                                   {"fy_px", camera_.k.fy_px},
                                   {"cx_px", camera_.k.cx_px},
                                   {"cy_px", camera_.k.cy_px}})
    EXPECT_NEAR(c[key].get<double>(), truth, 4 * c[std::string(key) + "_sigma"].get<double>())
        << key;
  EXPECT_LT(c["rms_px"].get<double>(), 0.15);
  EXPECT_EQ(c["board"]["dictionary"], "DICT_4X4_50");
  EXPECT_EQ(c["board"]["marker_mm"], 18);
  EXPECT_EQ(c["pictures_without_board"], json({"hidden.png"}));
  EXPECT_EQ(c["boards"].size(), 7U);
}

TEST_F(CharucoCommand, BadBoardsAndArguments) {
  const RigidTransform facing{Eigen::Matrix3d::Identity(), Eigen::Vector3d(-75, -50, 300)};
  const cv::Mat1b whole = photograph(camera_, facing);
  write_picture("a.png", whole);
  expect_refused(calibrate({"--charuco", "DICT_6X6_250", "--marker-mm", "18"}),
                 {"DICT_6X6_250 in 1 picture;", "a.png holds markers of DICT_4X4_50"});
  expect_refused(calibrate({"--charuco", "DICT_4X4_50", "--marker-mm", "26"}),
                 {"smaller than its squares"});
  expect_refused(calibrate({"--charuco", "DICT_9X9", "--marker-mm", "18"}),
                 {"'DICT_9X9' is no marker dictionary", "DICT_4X4_50"});
  const Outcome no_size = calibrate({"--charuco", "DICT_4X4_50"});
  EXPECT_NE(no_size.status, 0);
  EXPECT_THAT(no_size.err, HasSubstr("--charuco requires --marker-mm"));
  expect_refused(calibrate({"--charuco", "DICT_4X4_50", "--marker-mm", "18"}),
                 {"3 pictures, not 1"});

  // One row of corners determines no pose; two markers show fewer corners than count.
  cv::Mat1b row = whole.clone();
  const double y = project(camera_.k, camera_.lens, facing * Eigen::Vector3d(0, 12, 0)).y();
  row.rowRange(static_cast<int>(y), row.rows) = 120;
  write_picture("a.png", row);
  expect_refused(calibrate({"--charuco", "DICT_4X4_50", "--marker-mm", "18"}),
                 {"no 6 corners of a board with markers of DICT_4X4_50 in 1 picture;",
                  "sharp and evenly lit"});
}

}  // namespace
}  // namespace wheatstone::apps
