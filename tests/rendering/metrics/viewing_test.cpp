#include "rendering/metrics/viewing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "rendering/metrics/false_colour.h"
#include "rendering/metrics/flicker.h"
#include "rendering/metrics/pu21.h"
#include "vectors.h"

namespace wheatstone {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(),
                 kInfinity = std::numeric_limits<double>::infinity();

TEST(Viewing, PixelsPerDegreeOfAKnownDisplay) {
  // 3840x2160 px on a diagonal of 30 inch, seen from 747.2 mm (nancy_church.json, cvvdp).
  const double pitch_mm = 30 * 25.4 / std::hypot(3840.0, 2160.0);
  EXPECT_NEAR(pixels_per_degree(Length::of(pitch_mm), Length::of(747.2)), 75.40244934516305, 1e-9);
  for (const double bad : {0.0, -1.0, kNan, kInfinity}) {
    EXPECT_THROW(pixels_per_degree(Length::of(bad), 500.0_mm), ArgumentError);
    EXPECT_THROW(pixels_per_degree(0.1_mm, Length::of(bad)), ArgumentError);
  }
}

TEST(Viewing, ScaleTurnsNumbersIntoLight) {
  RgbImage stored(2, 1);
  stored.pixels(0, 0) = {0.5F, 1, 2};
  EXPECT_EQ(LightScale::absolute().light(RgbImage(stored.pixels.clone())).pixels(0, 0),
            cv::Vec3f(0.5F, 1, 2));
  EXPECT_EQ(LightScale::of_one(80.0_cd_m2).light(stored).pixels(0, 0), cv::Vec3f(40, 80, 160));
  for (const double bad : {0.0, -1.0, kNan, kInfinity})
    EXPECT_THROW(LightScale::of_one(Luminance::of(bad)), ArgumentError);
}

TEST(GogDisplay, LikeTheReferenceVectors) {
  const auto file = read_vectors("gog_display.json");
  int compared = 0;
  for (const auto& c : file["cases"]) {
    const GogDisplay display{c["Y_peak"], c["contrast"], c["gamma"], c["E_ambient_lux"],
                             c["k_refl"]};
    for (std::size_t i = 0; i < file["inputs"].size(); ++i, ++compared) {
      const double light = c["L"][i];  // written with ten digits
      EXPECT_NEAR(display.light_cd_m2(file["inputs"][i]), light, 1e-9 * light + 1e-10);
    }
  }
  EXPECT_EQ(compared, 18);
}

TEST(GogDisplay, ImpossibleDisplaysAreRefused) {
  const GogDisplay good{.peak_cd_m2 = 100};
  EXPECT_NO_THROW(good.light_cd_m2(0.5));
  EXPECT_THROW(GogDisplay{}.light_cd_m2(0.5), ArgumentError);  // no peak stated
  for (const double bad : {-1.0, kNan, kInfinity}) {
    for (double GogDisplay::*member :
         {&GogDisplay::peak_cd_m2, &GogDisplay::contrast, &GogDisplay::gamma,
          &GogDisplay::ambient_lux, &GogDisplay::reflectivity}) {
      GogDisplay display = good;
      display.*member = bad;
      EXPECT_THROW(display.light_cd_m2(0.5), ArgumentError);
    }
    EXPECT_THROW(good.light_cd_m2(bad), ArgumentError);
  }
  EXPECT_THROW(good.light_cd_m2(1.001), ArgumentError);
  GogDisplay in_the_sun = good;
  in_the_sun.ambient_lux = 1e5;
  EXPECT_THROW(in_the_sun.light_cd_m2(0.5), ArgumentError);
}

RgbImage grey(float light) {
  RgbImage out(8, 6);
  out.pixels.setTo(cv::Scalar::all(light));
  return out;
}

TEST(Flicker, IsTheRmsOfWhatChangesMoreThanTheReference) {
  // The test is 3 units too bright in every second frame; so each step is off by 3 units.
  FlickerMeter meter;
  for (int t = 0; t < 5; ++t) {
    const double reference_pu = 200 + 20 * t, test_pu = reference_pu + (t % 2 ? 3 : 0);
    meter.add(grey(static_cast<float>(pu21_decode(test_pu))),
              grey(static_cast<float>(pu21_decode(reference_pu))));
  }
  EXPECT_EQ(meter.frames(), 5);
  ASSERT_EQ(meter.steps_pu().size(), 4U);
  for (const double step : meter.steps_pu()) EXPECT_NEAR(step, 3, 1e-3);
  EXPECT_NEAR(meter.flicker_pu(), 3, 1e-3);
}

TEST(Flicker, AnErrorThatStaysDoesNotFlicker) {
  FlickerMeter meter;
  for (int t = 0; t < 4; ++t)
    meter.add(grey(static_cast<float>(pu21_decode(210 + 20 * t))),
              grey(static_cast<float>(pu21_decode(200 + 20 * t))));
  EXPECT_NEAR(meter.flicker_pu(), 0, 1e-3);
}

TEST(Flicker, ImpossibleSequencesAreRefused) {
  FlickerMeter meter;
  EXPECT_THROW(meter.flicker_pu(), ArgumentError);
  meter.add(grey(1), grey(1));
  EXPECT_THROW(meter.flicker_pu(), ArgumentError);  // one frame has no step
  EXPECT_THROW(meter.add(RgbImage(6, 8), RgbImage(6, 8)), ArgumentError);
  EXPECT_THROW(meter.add(grey(1), grey(-1)), ArgumentError);
  EXPECT_EQ(meter.frames(), 1);
  meter.add(grey(1), grey(1));
  EXPECT_EQ(meter.flicker_pu(), 0);
}

TEST(FalseColour, KeepsTheWidthAndGrowsLighter) {
  ScalarImage ramp(320, 40);
  for (int c = 0; c < 320; ++c) ramp.pixels.col(c).setTo(c / 319.0 * 60 - 5);  // beyond both ends
  const cv::Mat3b picture = false_colour_difference(ramp, 50, "PU21 units");
  EXPECT_EQ(picture.cols, 320);
  EXPECT_GT(picture.rows, 40);
  const auto lightness = [&](int c) {
    const cv::Vec3b p = picture(20, c);
    return 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
  };
  for (int c = 1; c < 320; ++c) EXPECT_GE(lightness(c), lightness(c - 1) - 2) << c;
  EXPECT_GT(lightness(319), lightness(0) + 200);
}

TEST(FalseColour, OneStopIsTheSameStepEverywhere) {
  RgbImage light(17, 4);
  for (int c = 0; c < 17; ++c) light.pixels.col(c).setTo(cv::Scalar::all(std::exp2(c - 6)));
  const cv::Mat3b picture = false_colour_luminance(light, 1.0 / 64, 1024);
  // The colour of stop k is that of k sixteenths of the map, which a difference picture shows too.
  EXPECT_EQ(picture(0, 0), false_colour_luminance(light, 1, 2)(0, 0));
  EXPECT_EQ(picture(0, 16), false_colour_luminance(light, 1, 2)(0, 16));
  EXPECT_EQ(picture(0, 8), false_colour_luminance(light, 1.0 / 256, 4096)(0, 8));
  EXPECT_NE(picture(0, 7), picture(0, 8));
}

TEST(FalseColour, ImpossibleScalesAreRefused) {
  const ScalarImage map(8, 8);
  RgbImage light(8, 8);
  EXPECT_THROW(false_colour_difference(ScalarImage(), 1, ""), ArgumentError);
  EXPECT_THROW(false_colour_luminance(RgbImage(), 1, 2), ArgumentError);
  for (const double bad : {0.0, -1.0, kNan, kInfinity}) {
    EXPECT_THROW(false_colour_difference(map, bad, ""), ArgumentError);
    EXPECT_THROW(false_colour_luminance(light, bad, 10), ArgumentError);
    EXPECT_THROW(false_colour_luminance(light, 0.1, bad), ArgumentError);
  }
  EXPECT_THROW(false_colour_luminance(light, 2, 2), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
