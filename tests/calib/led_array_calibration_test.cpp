#include "calib/led_array_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/colour.h"
#include "core/error.h"
#include "core/random.h"

namespace wheatstone {
namespace {

TEST(GainGammaOffset, ReferenceVectors) {
  std::ifstream file(WHEATSTONE_SOURCE_DIR "/tests/vectors/hdr/ggo_fit.json");
  ASSERT_TRUE(file);
  const auto json = nlohmann::json::parse(file);
  EXPECT_EQ(json["cases"].size(), 2u);
  for (const auto& v : json["cases"]) {
    std::vector<DriveReading> readings;
    for (std::size_t i = 0; i < v["drive"].size(); ++i)
      readings.push_back({v["drive"][i], v["luminance_cd_m2"][i]});
    const GainGammaOffsetFit fit = fit_gain_gamma_offset(readings);
    const auto near = [&](double value, const char* key) {
      const double expected = v["fit"][key];
      EXPECT_NEAR(value, expected, 1e-6 * std::max(1e-2, std::abs(expected))) << key;
    };
    near(fit.response.span_cd_m2, "L_span");
    near(fit.response.offset, "offset");
    near(fit.response.gain(), "gain");
    near(fit.response.gamma, "gamma");
    near(fit.response.black_cd_m2, "L_black");
    EXPECT_NEAR(fit.relative_rms, v["relative_rms"].get<double>(), 1e-7);
  }
}

TEST(GainGammaOffset, TheInverseReturnsTheDrive) {
  const GainGammaOffset r{3000, -0.05, 2.1, 0.01};
  EXPECT_DOUBLE_EQ(r.luminance_cd_m2(1), 3000.01);
  EXPECT_DOUBLE_EQ(r.luminance_cd_m2(0.02), 0.01);
  for (double d = 0.06; d <= 1; d += 0.047) EXPECT_NEAR(r.drive(r.luminance_cd_m2(d)), d, 1e-12);
  EXPECT_EQ(r.drive(5000), 1);
  EXPECT_NEAR(r.drive(0), 0.05 / 1.05, 1e-12);  // where light begins
}

TEST(GainGammaOffset, BadReadingsAreRefused) {
  const std::vector<DriveReading> good = {{0, 1}, {0.25, 5}, {0.5, 20}, {0.75, 60}, {1, 110}};
  const auto refused = [&](std::size_t i, DriveReading bad) {
    std::vector<DriveReading> readings = good;
    readings[i] = bad;
    EXPECT_THROW(fit_gain_gamma_offset(readings), ArgumentError);
  };
  EXPECT_NO_THROW(fit_gain_gamma_offset(good));
  refused(1, {1.25, 5});
  refused(1, {std::nan(""), 5});
  refused(1, {0.25, -5});
  refused(1, {0.25, std::nan("")});
  refused(4, {1, 0.5});
  EXPECT_THROW(fit_gain_gamma_offset({good.begin(), good.begin() + 4}), ArgumentError);
  EXPECT_THROW(fit_gain_gamma_offset({{0, 1}, {0, 1}, {1, 2}, {1, 2}, {1, 2}}), ArgumentError);
}

/// 16 x 16 LEDs whose emitters differ by some per cent in strength and colour.
std::vector<LedCalibration> ceiling() {
  RandomStream random(5, 1);
  const Eigen::Vector2d xy[3] = {{0.69, 0.305}, {0.19, 0.72}, {0.135, 0.05}};
  const double peak_cd_m2[3] = {2000, 4500, 700};
  std::vector<LedCalibration> leds(kLedRows * kLedColumns);
  for (LedCalibration& led : leds)
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector2d shift(0.003 * random.normal(), 0.003 * random.normal());
      led.xyz_cd_m2.col(c) =
          xyz_from_xyY(xy[c] + shift, peak_cd_m2[c] * (1 + 0.08 * random.normal()));
      led.responses[static_cast<std::size_t>(c)] = {peak_cd_m2[c], 0.02 * random.normal(),
                                                    1 + 0.3 * random.uniform(), 0.01};
    }
  return leds;
}

TEST(LedArray, EveryLedShowsTheStatedLight) {
  const std::vector<LedCalibration> leds = ceiling();
  for (const Eigen::Vector2d& xy : {Eigen::Vector2d(0.3127, 0.3290), Eigen::Vector2d(0.45, 0.41)})
    for (const double luminance : {0.0, 10.0, 1500.0}) {
      const std::vector<LedDrive> drives = led_drives(leds, luminance, xy);
      ASSERT_EQ(drives.size(), leds.size());
      for (std::size_t i = 0; i < leds.size(); ++i) {
        for (const double d : drives[i]) ASSERT_TRUE(d >= 0 && d <= 1);
        if (luminance > 0) {
          const Eigen::Vector3d expected = xyz_from_xyY(xy, luminance);
          EXPECT_LT((led_xyz_cd_m2(leds[i], drives[i]) - expected).norm(), 1e-9 * expected.norm());
        }
      }
    }
}

TEST(LedArray, TheLightWhenOffCounts) {
  std::vector<LedCalibration> leds = ceiling();
  for (LedCalibration& led : leds) led.off_xyz_cd_m2 = {1.5, 2, 1};
  const Eigen::Vector2d white(0.3127, 0.3290);
  const std::vector<LedDrive> drives = led_drives(leds, 50, white);
  const Eigen::Vector3d expected = xyz_from_xyY(white, 50);
  for (std::size_t i = 0; i < leds.size(); ++i)
    EXPECT_LT((leds[i].off_xyz_cd_m2 + led_xyz_cd_m2(leds[i], drives[i]) - expected).norm(),
              1e-9 * expected.norm());
  try {
    led_drives(leds, 1, white);
    FAIL();
  } catch (const ArgumentError& e) {
    EXPECT_THAT(e.what(), testing::AllOf(testing::HasSubstr("light when off"),
                                         testing::HasSubstr("ask for ")));
  }
}

TEST(LedArray, CalibratesFromReadings) {
  const LedCalibration truth = ceiling()[37];
  const Eigen::Vector3d off(0.02, 0.03, 0.01);
  std::array<Eigen::Vector3d, 3> full;
  std::array<std::vector<DriveReading>, 3> sweeps;
  for (std::size_t c = 0; c < 3; ++c) {
    full[c] = truth.xyz_cd_m2.col(static_cast<Eigen::Index>(c)) + off;
    for (double d = 0; d <= 1; d += 0.125)
      sweeps[c].push_back({d, truth.responses[c].luminance_cd_m2(d)});
  }
  const LedCalibration led = calibrate_led(full, off, sweeps);
  for (const LedDrive& d : {LedDrive{0.3, 0.6, 0.9}, LedDrive{1, 0.1, 0.5}}) {
    const Eigen::Vector3d expected = led_xyz_cd_m2(truth, d);
    EXPECT_LT((led_xyz_cd_m2(led, d) - expected).norm(), 1e-5 * expected.norm());
  }
  full[2] = full[1];
  EXPECT_THROW(calibrate_led(full, off, sweeps), ArgumentError);
}

TEST(LedArray, WhatAnLedCannotShowIsRefusedByPlace) {
  std::vector<LedCalibration> leds = ceiling();
  leds[2 * kLedColumns + 5].xyz_cd_m2 *= 0.1;
  const auto refused = [&](double luminance, Eigen::Vector2d xy, const std::string& part) {
    try {
      led_drives(leds, luminance, xy);
      FAIL() << part;
    } catch (const ArgumentError& e) {
      EXPECT_THAT(e.what(), testing::HasSubstr(part));
    }
  };
  refused(1500, {0.3127, 0.3290}, "row 2, column 5");
  refused(1, {0.05, 0.3}, "chromaticity");
  refused(-1, {0.3127, 0.3290}, "luminance");
  leds[9].xyz_cd_m2.setZero();
  refused(1, {0.3127, 0.3290}, "row 0, column 9");
}

}  // namespace
}  // namespace wheatstone
