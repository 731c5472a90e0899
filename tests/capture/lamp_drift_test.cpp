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
    const auto corrections =
        lamp_corrections({read_monitor_patch(view(1000, 2 * seed), patch),
                          read_monitor_patch(view(1040, 2 * seed + 1), patch)});
    ASSERT_EQ(corrections.size(), 2u);
    EXPECT_EQ(corrections[0].factor, 1);
    EXPECT_NEAR(corrections[1].factor, 1 / 1.04, 0.006);
    z2 += std::pow((corrections[1].factor - 1 / 1.04) / corrections[1].sigma, 2) / 200;
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
  try {
    lamp_corrections({{1000, 1}, {1010, 1}, {500, 1}});
    FAIL();
  } catch (const ArgumentError& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("view 2"));
  }
  EXPECT_THROW(lamp_corrections({{1000, 1}, {-3, 1}}), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
