#include "display/dual_modulation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "core/error.h"

namespace wheatstone {
namespace {

PanelModel panel() {
  PanelModel m;
  m.lcd_width_px = 512;
  m.lcd_height_px = 384;
  m.projector_width_px = 256;
  m.projector_height_px = 192;
  m.H_lcd_projector << 2, 0, 0.5, 0, 2, 0.5, 0, 0, 1;
  m.psf = {{1, 0.95}, {6, 0.05}};
  m.peak_cd_m2 = 3000;
  m.leak_cd_m2 = 0.005;
  m.lcd_black = 1e-3;
  m.projector_black = 5e-4;
  m.lcd_gamma = 2.2;
  m.projector_gamma = 2.0;
  return m;
}

const cv::Rect kInterior(32, 32, 448, 320);

RgbImage constant(cv::Vec3f v) {
  return RgbImage(cv::Mat3f(384, 512, v));
}

/// Largest |a - b| / b over the interior.
double relative_error(const cv::Mat3f& a, const cv::Mat3f& b) {
  double worst = 0;
  for (int y = kInterior.y; y < kInterior.br().y; ++y)
    for (int x = kInterior.x; x < kInterior.br().x; ++x)
      for (int c = 0; c < 3; ++c)
        worst = std::max(worst, std::abs(double{a(y, x)[c]} - b(y, x)[c]) / b(y, x)[c]);
  return worst;
}

cv::Mat1d matrix(const nlohmann::json& rows) {
  cv::Mat1d m(static_cast<int>(rows.size()), static_cast<int>(rows[0].size()));
  for (int y = 0; y < m.rows; ++y)
    for (int x = 0; x < m.cols; ++x) m(y, x) = rows[y][x];
  return m;
}

TEST(DualModulation, SqrtSplitReferenceVectors) {
  std::ifstream in(WHEATSTONE_SOURCE_DIR "/tests/vectors/dual_split.json");
  for (const auto& c : nlohmann::json::parse(in).at("cases")) {
    const auto kernel = gaussian_kernel(c.at("psf_sigma"), c.at("psf_radius"));
    for (std::size_t i = 0; i < kernel.size(); ++i)
      EXPECT_NEAR(kernel[i], c.at("psf_1d")[i].get<double>(), 1e-9);
    const cv::Mat1d target = matrix(c.at("target"));
    const double black = c.at("lcd_black");
    const SqrtSplit s = split_sqrt(target, kernel, black);
    const auto near = [](const cv::Mat1d& a, const cv::Mat1d& b) {
      return cv::norm(a, b, cv::NORM_INF) <= 1e-8 + 1e-7 * cv::norm(b, cv::NORM_INF);
    };
    EXPECT_TRUE(near(s.projector, matrix(c.at("projector_sqrt"))));
    EXPECT_TRUE(near(s.backlight, matrix(c.at("backlight_sqrt"))));
    EXPECT_TRUE(near(s.lcd, matrix(c.at("lcd_sqrt"))));
    EXPECT_TRUE(near(s.lcd.mul(s.backlight), matrix(c.at("output_sqrt"))));
  }
}

TEST(DualModulation, ConstantTargetsAreReproduced) {
  for (const float level : {100.0f, 317.0f, 1000.0f, 2500.0f, 3000.0f}) {
    const auto target = constant({level, level, level});
    const DualDrive d = split_dual_modulation(panel(), target);
    EXPECT_LT(relative_error(d.light_cd_m2.pixels, target.pixels), 0.01) << level;
    EXPECT_EQ(d.below_black_px, 0) << level;
  }
  for (const float level : {0.1f, 1.0f, 3.0f, 30.0f, 300.0f}) {  // in the mean over 4x4 pixels
    const auto target = constant({level, level, level});
    const auto d = split_dual_modulation(panel(), target, LcdRounding::kOrderedDither);
    cv::Mat3f mean;
    cv::resize(d.light_cd_m2.pixels, mean, {128, 96}, 0, 0, cv::INTER_AREA);
    cv::resize(mean, mean, {512, 384}, 0, 0, cv::INTER_NEAREST);
    EXPECT_LT(relative_error(mean, target.pixels), 0.01) << level;
  }
}

TEST(DualModulation, SmoothTargetsAreReproduced) {
  RgbImage target(512, 384);
  for (int y = 0; y < 384; ++y)
    for (int x = 0; x < 512; ++x) {
      const double wave = 1 + 0.5 * std::sin(2 * std::numbers::pi * (x / 200.0 + y / 150.0));
      target.pixels(y, x) = cv::Vec3f(1, 0.8f, 0.6f) * static_cast<float>(800 * wave);
    }
  const DualDrive d = split_dual_modulation(panel(), target);
  EXPECT_LT(relative_error(d.light_cd_m2.pixels, target.pixels), 0.015);
}

TEST(DualModulation, PredictionIsTheForwardModelAndBelowPeak) {
  cv::RNG random(7);
  RgbImage target(512, 384);
  random.fill(target.pixels, cv::RNG::UNIFORM, 0, 6000);  // half of it beyond the peak
  const DualDrive d = split_dual_modulation(panel(), target);
  EXPECT_EQ(d.projector.codes.type(), CV_8UC1);
  EXPECT_EQ(d.projector.codes.size(), cv::Size(256, 192));
  EXPECT_EQ(d.lcd.codes.type(), CV_8UC3);
  const RgbImage again = simulate_light(panel(), d.projector, d.lcd);
  EXPECT_LT(cv::norm(again.pixels, d.light_cd_m2.pixels, cv::NORM_INF), 1e-3);
  double most = 0;
  cv::minMaxLoc(d.light_cd_m2.pixels.reshape(1), nullptr, &most);
  EXPECT_LE(most, 3000.006);
  EXPECT_GT(d.above_peak_px, 512 * 384 / 2);
}

TEST(DualModulation, IsolatedBrightDotsGetEnoughBacklight) {
  for (const float level : {300.0f, 2000.0f, 2999.0f}) {
    auto target = constant({1, 1, 1});
    target.pixels(101, 203) = {level, 1, level / 2};
    const DualDrive d = split_dual_modulation(panel(), target);
    EXPECT_NEAR(d.light_cd_m2.pixels(101, 203)[0], level, 0.01 * level);
    EXPECT_NEAR(d.light_cd_m2.pixels(200, 400)[1], 1, 0.05);  // far away nothing changes
    double least = 0;                                         // no dark hole around the dot
    cv::minMaxLoc(d.light_cd_m2.pixels(cv::Rect(190, 90, 26, 22)).clone().reshape(1), &least);
    EXPECT_GT(least, 0.5) << level;
  }
}

TEST(DualModulation, DarkerThanBlackIsClippedAndCounted) {
  const DualDrive d = split_dual_modulation(panel(), constant({0, 0, 0}));
  EXPECT_EQ(d.below_black_px, 512 * 384);
  EXPECT_EQ(d.above_peak_px, 0);
  EXPECT_NEAR(d.light_cd_m2.pixels(200, 200)[0], 0.005 + 3000 * 1e-3 * 5e-4, 1e-5);
  EXPECT_EQ(cv::countNonZero(d.lcd.codes.reshape(1)), 0);
  const DualDrive b = split_dual_modulation(panel(), constant({4000, 10, 10}));
  EXPECT_EQ(b.above_peak_px, 512 * 384);
}

TEST(DualModulation, BacklightOfAConstantIsConstantAndEndsOutside) {
  const ScalarImage b = simulate_backlight(panel(), ScalarImage(256, 192, 0.5f));
  EXPECT_NEAR(b.pixels(190, 250), 0.5, 1e-6);
  EXPECT_LT(b.pixels(0, 0), 0.3);
  PanelModel half = panel();
  half.H_lcd_projector(0, 0) = 1;  // lights the left half only
  const ScalarImage h = simulate_backlight(half, ScalarImage(256, 192, 1));
  EXPECT_NEAR(h.pixels(190, 120), 1, 1e-6);
  EXPECT_EQ(h.pixels(190, 400), 0);
  PanelModel over = panel();  // overfills the LCD by 20 px: no falloff at its edges
  over.H_lcd_projector << 2.2, 0, -25, 0, 2.3, -25, 0, 0, 1;
  const ScalarImage o = simulate_backlight(over, ScalarImage(256, 192, 1));
  EXPECT_NEAR(o.pixels(0, 0), 1, 1e-5);
}

TEST(DualModulation, ObliqueProjectorIsRegistered) {
  PanelModel m = panel();
  m.H_lcd_projector << 2.3, 0.04, -20, -0.03, 2.35, -16, 2e-5, -1e-5, 1;
  const auto target = constant({500, 300, 200});
  const DualDrive d = split_dual_modulation(m, target);
  EXPECT_LT(relative_error(d.light_cd_m2.pixels, target.pixels), 0.01);
  EXPECT_EQ(d.above_peak_px, 0);
}

TEST(DualModulation, BadInputIsRefused) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(split_dual_modulation(panel(), constant({nan, 1, 1})), ArgumentError);
  EXPECT_THROW(split_dual_modulation(panel(), constant({-1, 1, 1})), ArgumentError);
  EXPECT_THROW(split_dual_modulation(panel(), RgbImage(511, 384)), ArgumentError);
  EXPECT_THROW(simulate_backlight(panel(), ScalarImage(255, 192)), ArgumentError);
  EXPECT_THROW(simulate_backlight(panel(), ScalarImage(256, 192, nan)), ArgumentError);
  EXPECT_THROW(simulate_light(panel(), {}, {}), ArgumentError);
  PanelModel m = panel();
  m.psf.clear();
  EXPECT_THROW(split_dual_modulation(m, constant({1, 1, 1})), ArgumentError);
  m = panel();
  m.H_lcd_projector.setZero();
  EXPECT_THROW(split_dual_modulation(m, constant({1, 1, 1})), ArgumentError);
  m = panel();
  m.peak_cd_m2 = 0;
  EXPECT_THROW(split_dual_modulation(m, constant({1, 1, 1})), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
