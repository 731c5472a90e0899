#include "capture/exposure_planning.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/random.h"
#include "sim/simulated_rig.h"
#include "tests/error_text.h"

namespace wheatstone {
namespace {

using ::testing::HasSubstr;

CameraProfile camera() {
  CameraProfile c;
  c.black_dn = 512;
  c.white_dn = 16000;
  c.dn_per_electron = {0.3, 0.25, 0.28};
  c.read_noise_e = 3;
  c.adc_noise = 2;
  return c;
}

/// Signal-to-noise ratio of light of `electrons_s` after the merge, by its definition: over the
/// frames that it does not saturate, and the shortest.
double merged_ratio(double electrons_s, std::vector<double> exposures_s, const CameraProfile& c) {
  const double k = *std::max_element(c.dn_per_electron.begin(), c.dn_per_electron.end());
  std::sort(exposures_s.begin(), exposures_s.end());
  double sum_s = 0;
  int frames = 0;
  for (const double t : exposures_s)
    if (frames == 0 || electrons_s * k * t < c.white_dn - c.black_dn) {
      sum_s += t;
      ++frames;
    }
  return signal_to_noise(electrons_s * sum_s, frames, c);
}

/// The worst ratio over all light of the range.
double worst_ratio(const LightRange& light, const std::vector<double>& exposures_s,
                   const CameraProfile& c) {
  const double k = *std::max_element(c.dn_per_electron.begin(), c.dn_per_electron.end());
  const double brightest_e_s = light.brightest_dn_s / k;
  double worst = 1e9;
  for (int i = 0; i <= 4000; ++i)
    worst = std::min(
        worst,
        merged_ratio(light.darkest_e_s * std::pow(brightest_e_s / light.darkest_e_s, i / 4000.0),
                     exposures_s, c));
  return worst;
}

TEST(ExposurePlanning, RatioIsThatOfTheNoiseModel) {
  const CameraProfile c = camera();
  EXPECT_NEAR(signal_to_noise(10000, 1, c), 10000 / std::sqrt(10000.0 + 13), 1e-9);
  EXPECT_NEAR(signal_to_noise(100, 3, c), 100 / std::sqrt(100.0 + 39), 1e-12);
  EXPECT_EQ(signal_to_noise(0, 1, c), 0);
}

TEST(ExposurePlanning, EveryLightReachesTheRatioAndNoSmallerSetDoes) {
  const CameraProfile c = camera();
  RandomStream random(3, 0);
  for (const double wanted : {10.0, 50.0, 120.0})
    for (const double decades : {0.5, 2.0, 3.5}) {
      const double brightest_dn_s = 2e6;
      const LightRange light{brightest_dn_s, brightest_dn_s / 0.3 * std::pow(10, -decades)};
      const std::vector<double> times = plan_exposures(light, c, wanted);
      EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
      EXPECT_GE(worst_ratio(light, times, c), 0.999 * wanted) << wanted << ' ' << decades;
      EXPECT_LE(times.front() * brightest_dn_s, 0.81 * (c.white_dn - c.black_dn));
      if (times.size() < 2) continue;
      // Sets with one time fewer, at random: none reaches the ratio everywhere.
      for (int i = 0; i < 200; ++i) {
        std::vector<double> fewer = {times.front()};
        while (fewer.size() + 1 < times.size())
          fewer.push_back(times.front() *
                          std::pow(1.2 * times.back() / times.front(), random.uniform()));
        EXPECT_LT(worst_ratio(light, fewer, c), wanted);
      }
    }
}

TEST(ExposurePlanning, NoTimeIsThereForARounding) {
  const CameraProfile c = camera();
  for (int wanted = 20; wanted < 120; ++wanted) {
    const LightRange light{2e6, 2e4};
    std::vector<double> times = plan_exposures(light, c, wanted);
    for (std::size_t i = 1; i < times.size(); ++i) EXPECT_GE(times[i], 1.29 * times[i - 1]);
    if (times.size() < 2) continue;
    times.pop_back();
    EXPECT_LT(worst_ratio(light, times, c), 0.999 * wanted) << "the last time does nothing";
  }
}

TEST(ExposurePlanning, SaysWhatCannotBeReached) {
  const CameraProfile c = camera();
  const auto error = [&](const LightRange& light, double wanted) {
    return error_of([&] { plan_exposures(light, c, wanted); });
  };
  EXPECT_THAT(error({1e5, 1e3}, 0), HasSubstr("above 0"));
  EXPECT_THAT(error({1e5, 1e3}, std::nan("")), HasSubstr("above 0"));
  EXPECT_THAT(error({0, 0}, 10), HasSubstr("no light"));
  EXPECT_THAT(error({1e5, 0}, 10), HasSubstr("no light"));
  EXPECT_THAT(error({1e5, 1e3}, 1000), HasSubstr("more than this camera"));
  EXPECT_THAT(error({1e9, 1e3}, 10), HasSubstr("shortest"));
  EXPECT_THAT(error({1e5, 1e-2}, 50), HasSubstr("in 30 s it reaches"));
}

TEST(ExposurePlanning, TheProbeSeesTheRangeOfTheBox) {
  SimulatedRig twin({"card", 0.05, 7});
  const Rig rig = twin.rig();
  const LightRange light = probe_light(rig, {3}, 0.9, {});
  EXPECT_TRUE(twin.world().light == BoxLight{});
  // A white card of 400 cd/m^2 at full light, black walls around it.
  const double white_dn_s = rig.camera_profile.dn_per_cd_m2_s * kCardWhiteCdM2;
  EXPECT_GT(light.brightest_dn_s, 0.5 * white_dn_s);
  EXPECT_LT(light.brightest_dn_s, 2 * white_dn_s);
  EXPECT_GT(light.darkest_e_s, 0);
  EXPECT_LT(light.darkest_e_s, light.brightest_dn_s);
  EXPECT_THAT(error_of([&] { probe_light(rig, {3}, 1, {}); }), HasSubstr("coverage"));
  std::stop_source stopped;
  stopped.request_stop();
  EXPECT_THAT(error_of([&] { probe_light(rig, {3}, 0.9, stopped.get_token()); }),
              HasSubstr("resume"));
  EXPECT_TRUE(twin.world().light == BoxLight{});
}

}  // namespace
}  // namespace wheatstone
