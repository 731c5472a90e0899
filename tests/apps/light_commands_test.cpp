// calibrate colour, calibrate leds and leds, on tables made from known truth.

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "calib/led_array_calibration.h"
#include "core/colour.h"
#include "core/csv.h"
#include "core/exr.h"
#include "core/png.h"
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

// As merge --frames writes a chart: beside the patches there are negative and broken samples.
TEST_F(ColourCommand, OnlyThePatchesMustBeLight) {
  const auto store = [&](cv::Rect area, float value) {
    const std::vector<ExrView> views = read_exr_views(path("plain.exr"));
    write_exr_rows(path("chart.exr"), {{80, 40}, {{"B"}, {"G"}, {"R"}}},
                   [&](cv::Range rows, std::span<cv::Mat1f> bands) {
                     const char* const names[] = {"B", "G", "R"};
                     for (std::size_t i = 0; i < 3; ++i) {
                       cv::Mat1f plane = views[0].channels.at(names[i]).pixels.clone();
                       plane(area).setTo(value);
                       plane.rowRange(rows).copyTo(bands[i]);
                     }
                   });
  };
  std::filesystem::copy_file(path("chart.exr"), path("plain.exr"));
  for (const float value : {-3.0F, std::numeric_limits<float>::quiet_NaN()}) {
    store({0, 0, 80, 1}, value);
    const Outcome outcome = run();
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const CameraProfile found = read_camera_profile(root_ / "out.json");
    EXPECT_LT((found.dn_per_cd_m2_s * found.camera_from_bt709 * M_ - Eigen::Matrix3d::Identity())
                  .cwiseAbs()
                  .maxCoeff(),
              1e-4);
  }
  std::filesystem::remove(path("out.json"));
  store({31, 5, 2, 2}, std::numeric_limits<float>::quiet_NaN());
  expect_refused(run(), {"chart.csv:5: patch p3", "not finite"});
  store({30, 0, 10, 40}, -3);
  expect_refused(run(), {"chart.csv:5: patch p3", "is black"});
  EXPECT_FALSE(std::filesystem::exists(path("out.json")));
}

TEST_F(ColourCommand, ReadingsThatCannotBeRightAreToldOrRefused) {
  const auto line_of = [&](const std::string& patch) {
    const std::size_t start = table_.find(patch + ",");
    return table_.substr(start, table_.find('\n', start) + 1 - start);
  };
  const auto with = [&](const std::string& patch, const std::string& line) {
    std::string text = table_;
    const std::string old = line_of(patch);
    return text.replace(text.find(old), old.size(), line);
  };
  write("chart.csv", with("p2", "p2,21,2,8,30,10,-4,3\n"));
  expect_refused(run(), {"chart.csv:4: patch p2", "-4"});

  // The places of two patches exchanged.
  std::string text = table_;
  text.replace(text.find("p1,11,"), 6, "p1,51,").replace(text.find("p5,51,"), 6, "p5,11,");
  write("chart.csv", text);
  const Outcome swapped = run();
  if (swapped.status != 0)
    expect_refused(swapped, {"chart.csv", "p1 and p5 seem to be swapped"});
  else
    EXPECT_THAT(swapped.err,
                AllOf(HasSubstr("warning"), HasSubstr("p1 and p5 seem to be swapped")));

  // One reading off by half: a warning, and by a factor of 20: nothing is written.
  const auto scaled = [&](double factor) {
    std::istringstream cells(line_of("p4"));
    std::string line;
    int column = 0;
    for (std::string cell; std::getline(cells, cell, ','); ++column)
      line += (column ? "," : "") + (column < 5 ? cell : std::to_string(factor * std::stod(cell)));
    write("chart.csv", with("p4", line + "\n"));
    return run();
  };
  const Outcome off = scaled(1.3);
  EXPECT_EQ(off.status, 0);
  EXPECT_THAT(off.err, AllOf(HasSubstr("% RMS"), HasSubstr("p4 (")));
  std::filesystem::remove(path("out.json"));
  expect_refused(scaled(20), {"chart.csv", "% RMS", "p4 ("});
  EXPECT_FALSE(std::filesystem::exists(path("out.json")));

  // camera_ says 1 DN per cd/m^2 s, the chart about 60.
  write("chart.csv", table_);
  EXPECT_THAT(run().err, HasSubstr("times as sensitive"));
  camera_.dn_per_cd_m2_s = read_camera_profile(root_ / "out.json").dn_per_cd_m2_s;
  write_camera_profile(root_ / "camera.json", camera_);
  EXPECT_EQ(run().err, "");
}

/// Pairs of flat fields of a sensor with 0.4 DN per electron and a black level of 200 DN.
class NoiseCommand : public LightCommands {
 protected:
  Outcome measure(int stated_black, double flicker = 0) {
    RandomStream random(3, 1);
    nlohmann::json pairs = nlohmann::json::array();
    for (int p = 0; p < 5; ++p) {
      std::string names[2];
      for (int f = 0; f < 2; ++f) {
        MosaicImage frame{cv::Mat1w(128, 128)};
        for (auto& dn : frame.dn) {
          const double electrons =
              std::max(0.0, (500 + 1500.0 * p) * (1 + flicker * random.normal()));
          dn = static_cast<std::uint16_t>(
              std::lround(200 + 0.4 * (electrons + std::sqrt(electrons) * random.normal())));
        }
        names[f] = "flat_" + std::to_string(2 * p + f) + ".png";
        write_mosaic_png(path(names[f]), frame);
      }
      pairs.push_back({{"a", names[0]}, {"b", names[1]}, {"gain", 1}});
    }
    write("flats.json", nlohmann::json{{"camera", "made up"},
                                       {"pattern", "RGGB"},
                                       {"bits", 14},
                                       {"black", stated_black},
                                       {"saturation", 16383},
                                       {"pairs", pairs}}
                            .dump());
    return run_program({"measure-noise", "--flats", path("flats.json"), "--out", path("o.toml")});
  }
};

TEST_F(NoiseCommand, AModelThatDoesNotFitIsToldOrRefused) {
  const Outcome good = measure(200);
  EXPECT_EQ(good.status, 0) << good.err;
  EXPECT_EQ(good.err, "");
  const Outcome doubtful = measure(200, 0.01);
  EXPECT_EQ(doubtful.status, 0) << doubtful.err;
  EXPECT_THAT(doubtful.err, AllOf(HasSubstr("warning"), HasSubstr("chi2 per measurement")));
  std::filesystem::remove(path("o.toml"));
  expect_refused(measure(200, 0.5), {"flats.json", "chi2 per measurement", "check black"});
  EXPECT_FALSE(std::filesystem::exists(path("o.toml")));
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
  EXPECT_THAT(calibrated.out, AllOf(HasSubstr("256 LEDs"), HasSubstr("largest residual")));
  EXPECT_EQ(calibrated.err, "");
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
  expect_refused(asked("1e5", "0.3127", "0.3290"), {"row", "ask for 0.0", " to "});
  // All off shows Y = 0.02.
  expect_refused(asked("0.01", "0.3127", "0.3290"), {"as little as 0.01", "ask for 0.0"});
  for (const char* none : {"0", "-3", "1e-310"})
    EXPECT_LT(asked(none, "0.3127", "0.3290").err.size(), 200U) << none;
  expect_refused(asked("-3", "0.3127", "0.3290"), {"--luminance is -3", "above 0"});
  expect_refused(asked("10", "0.9", "0.05"), {"row"});
  EXPECT_FALSE(std::filesystem::exists(path("d.csv")));
}

TEST_F(LedCommands, AReadingOffTheCurveIsNamed) {
  std::string text = readings();
  const std::size_t at = text.find("3,7,G,0.5,");
  const std::size_t end = text.find('\n', at);
  text.replace(at, end - at, "3,7,G,0.5,150,200,30");
  write("ceiling.csv", text);
  const Outcome outcome = run_program(
      {"calibrate", "leds", "--readings", path("ceiling.csv"), "--out", path("leds.json")});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("warning"), HasSubstr("row 3, column 7, G")));
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
  refused(good + "0,0,R,255,1,1,1\n", {"ceiling.csv:", "drive is 0 to 1", "as by 100 or 255"});
  refused(good.substr(0, good.find("15,15,")), {"row 15, column 15", "lacks"});
  refused("row,column\n0,0\n", {"ceiling.csv", "_cd_m2"});
  write("leds.json", "{}");
  expect_refused(run_program({"leds", "--calibration", path("leds.json"), "--luminance", "1",
                              "--xy", "0.3", "0.3", "--out", path("d.csv")}),
                 {"leds.json", "schema"});
}

}  // namespace
}  // namespace wheatstone::apps
