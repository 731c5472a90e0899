// calibrate colour, calibrate leds and leds, on tables made from known truth.

#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "calib/led_array_calibration.h"
#include "core/colour.h"
#include "core/csv.h"
#include "core/exr.h"
#include "core/random.h"
#include "program.h"

namespace wheatstone::apps {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class LightCommands : public TemporaryFolder {
 protected:
  void write(const std::string& name, const std::string& text) {
    std::ofstream(path(name)) << text;
  }
};

/// A chart of eight patches whose camera colours are those of a known matrix.
class ColourCommand : public LightCommands {
 protected:
  ColourCommand() {
    camera_.intrinsics = {100, 100, 0, 40, 20, 80, 40};
    camera_.white_dn = 4095;
    camera_.dn_per_cd_m2_s = 1;
    write_camera_profile(root_ / "camera.json", camera_);
    M_ << 0.02, -0.004, 0.001, -0.003, 0.015, -0.002, 0.0005, -0.006, 0.025;
    RgbImage chart(80, 40);
    RandomStream random(1, 0);
    std::string table = "patch,x_px,y_px,width_px,height_px,X_cd_m2,Y_cd_m2,Z_cd_m2\n";
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d light(20 + 300 * random.uniform(), 20 + 300 * random.uniform(),
                                  20 + 300 * random.uniform());
      const Eigen::Vector3d seen = M_.inverse() * light;
      const Eigen::Vector3d xyz = xyz_from_rgb(bt709_primaries()) * light;
      chart.pixels(cv::Rect(10 * i, 0, 10, 40)).setTo(cv::Scalar(seen.x(), seen.y(), seen.z()));
      char row[200];
      std::snprintf(row, sizeof row, "p%d,%d,2,8,30,%.9g,%.9g,%.9g\n", i, 10 * i + 1, xyz.x(),
                    xyz.y(), xyz.z());
      table += row;
    }
    write("chart.csv", table);
    table_ = table;
    write_exr(root_ / "chart.exr", chart, ExrPrecision::kFloat);
  }
  Outcome run(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {
        "calibrate",       "colour",   "--picture",         path("chart.exr"), "--patches",
        path("chart.csv"), "--camera", path("camera.json"), "--out",           path("out.json")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }

  CameraProfile camera_;
  Eigen::Matrix3d M_;
  std::string table_;
};

TEST_F(ColourCommand, FindsTheMatrixAndKeepsTheRest) {
  const Outcome outcome = run();
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("p3"), HasSubstr("left out"), HasSubstr("wrote ")));
  const CameraProfile found = read_camera_profile(root_ / "out.json");
  const Eigen::Matrix3d sensitivity = found.dn_per_cd_m2_s * found.camera_from_bt709;
  EXPECT_LT((sensitivity * M_ - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_EQ(found.white_dn, camera_.white_dn);
  EXPECT_EQ(found.intrinsics.cx_px, camera_.intrinsics.cx_px);

  const Outcome as_json = run({"--json", "--reference-patch", "p0"});
  const auto report = nlohmann::json::parse(as_json.out);
  EXPECT_EQ(report.at("patches").size(), 8U);
  EXPECT_NEAR(report["patches"][0]["relative_error"].get<double>(), 0, 1e-6);
}

TEST_F(ColourCommand, RefusesWhatCannotBe) {
  expect_refused(run({"--reference-patch", "grey"}), {"no patch named grey", "chart.csv"});
  write("chart.csv", table_ + "far,75,2,8,30,1,1,1\n");
  expect_refused(run(), {"chart.csv:10", "reaches out of the picture"});
  write("chart.csv", table_ + "odd,1.5,2,8,30,1,1,1\n");
  expect_refused(run(), {"x_px"});
  write("chart.csv", table_.substr(0, table_.find("p2")));
  expect_refused(run(), {"at least three"});
  write("chart.csv", "patch,x_px\na,1\n");
  expect_refused(run(), {"chart.csv", "y_px"});
  EXPECT_FALSE(std::filesystem::exists(path("out.json")));
  expect_nothing_half_written(root_);
}

/// A ceiling whose LEDs differ, measured without error.
class LedCommands : public LightCommands {
 protected:
  static LedCalibration truth(int led) {
    LedCalibration t;
    const double strength = 300 + led;
    t.xyz_cd_m2 << 0.45, 0.30, 0.17, 0.24, 0.68, 0.07, 0.01, 0.08, 0.95;
    t.xyz_cd_m2 *= strength;
    for (auto& r : t.responses) r = {1, -0.02, 1.8 + 0.001 * led, 0};
    return t;
  }
  std::string readings() {
    std::string text = "row,column,emitter,drive,X_cd_m2,Y_cd_m2,Z_cd_m2\n";
    for (int led = 0; led < 256; ++led) {
      const auto add = [&](const char* emitter, double drive, const LedDrive& drives) {
        const Eigen::Vector3d xyz =
            led_xyz_cd_m2(truth(led), drives) + Eigen::Vector3d(0.01, 0.02, 0.01);
        char row[200];
        std::snprintf(row, sizeof row, "%d,%d,%s,%.9g,%.9g,%.9g,%.9g\n", led / 16, led % 16,
                      emitter, drive, xyz.x(), xyz.y(), xyz.z());
        text += row;
      };
      add("off", 0, {0, 0, 0});
      for (const double d : {0.0, 0.1, 0.25, 0.5, 0.75, 1.0}) {
        add("R", d, {d, 0, 0});
        add("G", d, {0, d, 0});
        add("B", d, {0, 0, d});
      }
    }
    return text;
  }
};

TEST_F(LedCommands, LightsTheBoxAsAskedFor) {
  write("ceiling.csv", readings());
  const Outcome calibrated = run_program(
      {"calibrate", "leds", "--readings", path("ceiling.csv"), "--out", path("leds.json")});
  ASSERT_EQ(calibrated.status, 0) << calibrated.err;
  EXPECT_THAT(calibrated.out, HasSubstr("256 LEDs"));
  const Outcome outcome =
      run_program({"leds", "--calibration", path("leds.json"), "--luminance", "120", "--xy",
                   "0.3127", "0.3290", "--out", path("drives.csv")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const CsvTable drives = CsvTable::read(path("drives.csv"));
  ASSERT_EQ(drives.rows(), 256U);
  const Eigen::Vector3d wanted = xyz_from_xyY({0.3127, 0.3290}, 120);
  for (std::size_t led = 0; led < 256; ++led) {
    const Eigen::Vector3d shown = led_xyz_cd_m2(
        truth(static_cast<int>(led)), {drives.number(led, "drive_r"), drives.number(led, "drive_g"),
                                       drives.number(led, "drive_b")});
    EXPECT_LT((shown - wanted).norm() / wanted.norm(), 0.01) << led;
  }
  const std::vector<std::string> ask = {"leds",  "--calibration", path("leds.json"),
                                        "--out", path("d.csv"),   "--luminance"};
  const auto asked = [&](const std::string& luminance, const std::string& x, const std::string& y) {
    std::vector<std::string> arguments = ask;
    arguments.insert(arguments.end(), {luminance, "--xy", x, y});
    return run_program(arguments);
  };
  expect_refused(asked("1e5", "0.3127", "0.3290"), {"row"});
  expect_refused(asked("10", "0.9", "0.05"), {"row"});
  EXPECT_FALSE(std::filesystem::exists(path("d.csv")));
}

TEST_F(LedCommands, RefusesReadingsThatDoNotSuffice) {
  const std::string good = readings();
  const auto refused = [&](const std::string& text, const std::vector<std::string>& parts) {
    write("ceiling.csv", text);
    expect_refused(run_program({"calibrate", "leds", "--readings", path("ceiling.csv"), "--out",
                                path("leds.json")}),
                   parts);
    EXPECT_FALSE(std::filesystem::exists(path("leds.json")));
  };
  refused(good + "16,0,R,1,1,1,1\n", {"row", "below 16"});
  refused(good + "0,0,W,1,1,1,1\n", {"no emitter W"});
  refused(good.substr(0, good.find("15,15,")), {"row 15, column 15", "lacks"});
  refused("row,column\n0,0\n", {"ceiling.csv", "_cd_m2"});
  write("leds.json", "{}");
  expect_refused(run_program({"leds", "--calibration", path("leds.json"), "--luminance", "1",
                              "--xy", "0.3", "0.3", "--out", path("d.csv")}),
                 {"leds.json", "schema"});
}

}  // namespace
}  // namespace wheatstone::apps
