#include "capture/lamp_drift.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/random.h"

namespace wheatstone {
namespace {

/// A view of constant light with deviations of 2 %.
MergedMosaic view(double light_dn_s, std::uint64_t seed) {
  RandomStream random(seed, 0);
  MergedMosaic m{{cv::Mat1f(40, 60)}, cv::Mat1f(40, 60), cv::Mat1b(40, 60, std::uint8_t{0})};
  m.sigma_dn_s = static_cast<float>(0.02 * light_dn_s);
  for (float& v : m.mosaic.values)
    v = static_cast<float>(light_dn_s * (1 + 0.02 * random.normal()));
  return m;
}

TEST(LampDrift, CorrectsToTheFirstViewWithItsError) {
  const cv::Rect patch(4, 6, 30, 20);
  double z2 = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const LampCorrection correction =
        lamp_correction(read_monitor_patch(view(1000, 2 * seed), patch),
                        read_monitor_patch(view(1040, 2 * seed + 1), patch));
    EXPECT_NEAR(correction.factor, 1 / 1.04, 0.006);
    z2 += std::pow((correction.factor - 1 / 1.04) / correction.sigma, 2) / 200;
  }
  EXPECT_NEAR(std::sqrt(z2), 1, 0.15);
}

TEST(LampDrift, BadPatchesAreRefused) {
  MergedMosaic m = view(1000, 1);
  EXPECT_THROW(read_monitor_patch(m, {50, 30, 20, 20}), ArgumentError);
  EXPECT_THROW(read_monitor_patch(m, {5, 5, 0, 3}), ArgumentError);
  m.flags(10, 10) = kSaturated;
  EXPECT_THROW(read_monitor_patch(m, {5, 5, 20, 20}), ArgumentError);
  m.flags(10, 10) = kSingleSource;
  EXPECT_NO_THROW(read_monitor_patch(m, {5, 5, 20, 20}));
  EXPECT_NO_THROW(lamp_correction({1000, 1}, {810, 1}));
  try {
    lamp_correction({1000, 1}, {500, 1});
    FAIL();
  } catch (const ArgumentError& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("0.5 times the light of the first view's"));
  }
  EXPECT_THROW(lamp_correction({1000, 1}, {-3, 1}), ArgumentError);
  EXPECT_THROW(lamp_correction({0, 1}, {1000, 1}), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
