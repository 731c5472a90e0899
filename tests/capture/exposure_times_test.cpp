#include "capture/exposure_times.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/png.h"
#include "core/random.h"

namespace wheatstone {
namespace {

const std::string kVectors = WHEATSTONE_SOURCE_DIR "/tests/vectors/hdr/";

// The reference selects pixels in float, so that ties fall differently. They decide most without
// weights, where any of the selected pixels may stay.
TEST(ExposureTimes, ReferenceVectors) {
  std::ifstream file(kVectors + "exposure_estimation.json");
  ASSERT_TRUE(file);
  const auto json = nlohmann::json::parse(file);
  EXPECT_EQ(json["cases"].size(), 2u);
  for (const auto& v : json["cases"]) {
    MergeOptions options;
    options.black_dn.fill(v["black_level"]);
    options.saturation_dn = (1 << v["bits"].get<int>()) - 1;
    std::vector<RawExposure> stack;
    for (std::size_t i = 0; i < v["files"].size(); ++i)
      stack.push_back({read_mosaic_png(kVectors + v["files"][i].get<std::string>(),
                                       bayer_pattern_from_string(v["pattern"])),
                       Duration::of(v["nominal_exposure_s"][i].get<double>())});
    for (const auto& [name, estimates] : v["estimates"].items()) {
      const bool weighted = name.ends_with("_wls");
      const ExposurePairing pairing = exposure_pairing_from_string(name.substr(0, name.find('_')));
      const ExposureTimes t = estimate_exposure_times(stack, options, pairing, weighted);
      EXPECT_EQ(t.note, "");
      EXPECT_GT(t.equations, 1000);
      for (std::size_t i = 0; i < stack.size(); ++i) {
        const double upstream = estimates[i], truth = v["true_exposure_s"][i];
        EXPECT_TRUE(t.estimated[i]);
        EXPECT_NEAR(t.exposure_s[i], upstream, (weighted ? 1e-4 : 2e-3) * upstream)
            << v["name"] << name << i;
        const double allowed = weighted && pairing == ExposurePairing::kMst ? 0.003 : 0.02;
        EXPECT_NEAR(t.exposure_s[i], truth, allowed * truth) << v["name"] << name << i;
      }
    }
  }
}

/// A smooth scene of some 30 : 1 with photon noise, as frames of the given true times.
std::vector<RawExposure> scene(const std::vector<double>& true_s, const std::vector<double>& said_s,
                               int size = 128, double brightness = 8000) {
  RandomStream random(4, 2);
  std::vector<RawExposure> stack;
  for (std::size_t i = 0; i < true_s.size(); ++i) {
    RawExposure e{{cv::Mat1w(size, size), BayerPattern::kGrbg}, Duration::of(said_s[i])};
    for (int r = 0; r < size; ++r)
      for (int c = 0; c < size; ++c) {
        const double light = brightness * std::exp(1.7 * std::sin(r / 9.0) * std::cos(c / 13.0));
        const double dn = 512 + 0.4 * random.poisson(light * true_s[i] / 0.4);
        e.frame.dn(r, c) = static_cast<std::uint16_t>(std::min(16383.0, std::round(dn)));
      }
    stack.push_back(e);
  }
  return stack;
}

MergeOptions camera() {
  MergeOptions o;
  o.black_dn.fill(512);
  o.saturation_dn = 16383;
  return o;
}

TEST(ExposureTimes, FindsJitterInAnyOrderAndGain) {
  std::vector<RawExposure> stack = scene({0.33, 0.0595, 1, 0.11}, {0.3, 0.0625, 1, 0.125});
  stack[1].gain = 1;
  for (const bool with_noise : {false, true}) {
    MergeOptions options = camera();
    if (with_noise) options.noise = SensorNoise{{0.4, 0.4, 0.4}, 0.7, 1};
    const ExposureTimes t = estimate_exposure_times(stack, options, ExposurePairing::kMst, true);
    EXPECT_NEAR(t.exposure_s[0], 0.33, 0.003 * 0.33);
    EXPECT_NEAR(t.exposure_s[1], 0.0595, 0.003 * 0.0595);
    EXPECT_EQ(t.exposure_s[2], 1);
    EXPECT_NEAR(t.exposure_s[3], 0.11, 0.003 * 0.11);
  }
}

TEST(ExposureTimes, WhatCannotBeEstimatedKeepsItsTimeAndSaysSo) {
  const std::vector<double> two = {0.1, 0.4};
  ExposureTimes t = estimate_exposure_times(scene(two, two), camera(), ExposurePairing::kMst, true);
  EXPECT_EQ(t.exposure_s, two);
  EXPECT_THAT(t.estimated, testing::Each(false));
  EXPECT_THAT(t.note, testing::HasSubstr("fewer than three"));

  const std::vector<double> four = {0.05, 0.1, 0.4, 300};  // the last one is all white
  t = estimate_exposure_times(scene(four, four), camera(), ExposurePairing::kPairwise, true);
  EXPECT_THAT(t.estimated, testing::ElementsAre(true, true, true, false));
  EXPECT_EQ(t.exposure_s[3], 300);
  EXPECT_THAT(t.note, testing::HasSubstr("frame 3"));

  t = estimate_exposure_times(scene({0.1, 0.2, 0.4}, {0.02, 0.2, 0.4}), camera(),
                              ExposurePairing::kMst, true);
  EXPECT_THAT(t.estimated, testing::ElementsAre(false, true, true));
  EXPECT_EQ(t.exposure_s[0], 0.02);
  EXPECT_THAT(t.note, testing::HasSubstr("200 %"));
}

TEST(ExposureTimes, BadInputIsRefused) {
  const std::vector<double> s = {0.1, 0.2, 0.4};
  EXPECT_THROW(estimate_exposure_times(scene(s, s, 14), camera(), ExposurePairing::kMst, true),
               ArgumentError);
  EXPECT_THROW(estimate_exposure_times({}, camera(), ExposurePairing::kMst, true), ArgumentError);
  EXPECT_THROW(
      estimate_exposure_times(scene(s, {0.1, 0.1, 0.4}), camera(), ExposurePairing::kMst, true),
      ArgumentError);
  EXPECT_THROW(exposure_pairing_from_string("histogram"), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
