#include "capture/exposure_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/random.h"

namespace wheatstone {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kBlack = 512, kSaturation = 16383;

/// Light of 1000 : 1 as a sensor of 14 bits with photon noise sees it.
RawExposure exposure(double time_s, double gain = 1, double actual_time_s = 0) {
  RawExposure out{{cv::Mat1w(60, 80)}, Duration::of(time_s), gain};
  RandomStream random(5, static_cast<std::uint64_t>(1e6 * time_s));
  for (int r = 0; r < 60; ++r)
    for (int c = 0; c < 80; ++c) {
      const double light_dn_s = 1000 * std::pow(1000, (r + c) / 138.0);
      const double dn = light_dn_s * gain * (actual_time_s > 0 ? actual_time_s : time_s);
      out.frame.dn(r, c) = static_cast<std::uint16_t>(std::clamp(
          std::lround(kBlack + dn + std::sqrt(0.4 * dn) * random.normal()), 0L, long{kSaturation}));
    }
  return out;
}

MergeOptions options() {
  MergeOptions out;
  out.black_dn.fill(kBlack);
  out.saturation_dn = kSaturation;
  return out;
}

TEST(ExposureCheck, AStackThatAgreesIsQuiet) {
  const std::vector<RawExposure> stack = {exposure(0.25), exposure(0.004), exposure(0.0625),
                                          exposure(0.016, 2)};
  EXPECT_TRUE(contradicting_exposures(stack, options()).empty());
  for (const RawExposure& e : stack) EXPECT_EQ(pile_up(e.frame, kSaturation).share, 0);
  const std::vector<std::string> names = {"a", "b", "c", "d"};
  EXPECT_TRUE(exposure_warnings(stack, options(), names).empty());
}

TEST(ExposureCheck, MeasuresTheRatioOfNeighbours) {
  for (const double error : {1.1, 1.15, 0.95, 0.85}) {
    const std::vector<RawExposure> stack = {exposure(0.04, 1, error * 0.04), exposure(0.01)};
    const auto found = contradicting_exposures(stack, options());
    ASSERT_EQ(found.size(), std::abs(error - 1) > 0.12 ? 1U : 0U) << error;
    if (found.empty()) continue;
    EXPECT_EQ(found[0].shorter, 1U);
    EXPECT_EQ(found[0].longer, 0U);
    EXPECT_NEAR(found[0].stated, 4, 1e-12);
    EXPECT_NEAR(found[0].measured, 4 * error, 0.03);
  }
}

TEST(ExposureCheck, SwappedTimesWrongGainsAndBlackLevelsAreFound) {
  const std::vector<std::string> names = {"short.png", "long.png"};
  const auto warnings = [&](const RawExposure& a, const RawExposure& b, const MergeOptions& o) {
    return exposure_warnings(std::vector{a, b}, o, names);
  };
  RawExposure a = exposure(0.01), b = exposure(0.04);
  ASSERT_TRUE(warnings(a, b, options()).empty());
  std::swap(a.exposure, b.exposure);
  EXPECT_THAT(warnings(a, b, options()),
              testing::ElementsAre(AllOf(HasSubstr("short.png"), HasSubstr("long.png"))));
  std::swap(a.exposure, b.exposure);
  b.gain = 100;
  EXPECT_EQ(warnings(a, b, options()).size(), 1U);
  b.gain = 1;
  MergeOptions no_black = options();
  no_black.black_dn.fill(0);
  EXPECT_EQ(warnings(a, b, no_black).size(), 1U);
  // One frame under two times.
  b = a;
  b.exposure = Duration::of(0.04);
  EXPECT_EQ(warnings(a, b, options()).size(), 1U);
}

TEST(ExposureCheck, SaturationBelowWhatIsStatedIsFound) {
  const RawExposure bright = exposure(0.25);
  const PileUp found = pile_up(bright.frame, 65535);
  EXPECT_EQ(found.highest_dn, kSaturation);
  const int at_top = cv::countNonZero(bright.frame.dn == kSaturation);
  EXPECT_NEAR(found.share, at_top / 4800.0, 1e-12);
  MergeOptions sixteen_bits = options();
  sixteen_bits.saturation_dn = 65535;
  const std::vector<std::string> names = {"bright.png"};
  EXPECT_THAT(exposure_warnings(std::vector{bright}, sixteen_bits, names),
              testing::ElementsAre(AllOf(HasSubstr("bright.png"), HasSubstr("16383"))));
}

TEST(ExposureCheck, FewPhotositesAreNotJudged) {
  const auto few = [](std::uint16_t dn, double time_s) {
    return RawExposure{{cv::Mat1w(9, 11, dn)}, Duration::of(time_s)};
  };
  EXPECT_TRUE(
      contradicting_exposures(std::vector{few(2000, 0.01), few(2000, 0.04)}, options()).empty());
  EXPECT_EQ(pile_up({cv::Mat1w()}, 100).share, 0);
  EXPECT_EQ(pile_up({cv::Mat1w(4, 4, std::uint16_t{0})}, 100).share, 0) << "dark, not bright";
}

TEST(ExposureCheck, BadStacksAreRefused) {
  const std::vector<RawExposure> stack = {exposure(0.01), exposure(0.01)};
  EXPECT_THROW(contradicting_exposures(stack, options()), ArgumentError);
  EXPECT_THROW(exposure_warnings(std::vector{exposure(0.01)}, options(), {}), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
