#include "capture/merge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/random.h"

namespace wheatstone {
namespace {

MergeOptions camera() {
  MergeOptions o;
  o.black_dn.fill(512);
  o.saturation_dn = 16383;
  o.noise = SensorNoise{{0.42, 0.38, 0.39}, 0.7, 3};
  return o;
}

RawExposure flat(int width, int height, int dn, double seconds) {
  return {{cv::Mat1w(height, width, static_cast<std::uint16_t>(dn)), BayerPattern::kRggb},
          Duration::of(seconds)};
}

TEST(Merge, ReferenceVectors) {
  std::ifstream file(WHEATSTONE_SOURCE_DIR "/tests/vectors/hdr/merge_stacks.json");
  ASSERT_TRUE(file);
  const auto json = nlohmann::json::parse(file);
  EXPECT_EQ(json["cases"].size(), 5u);
  for (const auto& v : json["cases"]) {
    const std::string name = v["name"];
    MergeOptions options;
    options.black_dn.fill(v["black_level"]);
    options.saturation_dn = (1 << v["bits"].get<int>()) - 1;
    options.noise =
        SensorNoise{v["noise_k_rgb"].get<std::array<double, 3>>(), v["std_read"], v["std_adc"]};
    const BayerPattern pattern = bayer_pattern_from_string(v["pattern"]);
    const int rows = v["rows"], cols = v["cols"];
    std::vector<RawExposure> stack;
    for (std::size_t i = 0; i < v["images"].size(); ++i) {
      RawExposure e{{cv::Mat1w(rows, cols), pattern},
                    Duration::of(v["exposure_s"][i].get<double>()),
                    v["gain"][i].get<double>()};
      for (int r = 0; r < rows; ++r)
        for (int c = 0; c < cols; ++c) e.frame.dn(r, c) = v["images"][i][r][c].get<std::uint16_t>();
      stack.push_back(e);
    }
    for (const auto& [key, estimator, tolerance] :
         {std::tuple("expected_poisson_estimator", MergeEstimator::kPoisson, 1e-6),
          std::tuple("expected_full_noise_estimator", MergeEstimator::kFullNoise, 1e-5)}) {
      options.estimator = estimator;
      const MergedMosaic m = merge_exposures(stack, options);
      for (int r = 0; r < rows; ++r)
        for (int c = 0; c < cols; ++c) {
          const double expected = v[key][r][c];
          EXPECT_NEAR(m.mosaic.values(r, c), expected,
                      tolerance * std::max(1.0, std::abs(expected)))
              << name << " " << key << " " << r << "," << c;
          EXPECT_EQ((m.flags(r, c) & kSaturated) == 0,
                    v["unsaturated_in_shortest"][r][c].get<int>() == 1)
              << name << " " << r << "," << c;
        }
    }
  }
}

TEST(Merge, OneSaturatedPixelExcludesItsCell) {
  std::vector<RawExposure> stack = {flat(5, 3, 612, 0.1), flat(5, 3, 2512, 1)};
  stack[1].frame.dn(1, 1) = 16383;
  const MergedMosaic m = merge_exposures(stack, camera());
  EXPECT_FLOAT_EQ(m.mosaic.values(0, 0), 1000);          // shortest alone
  EXPECT_NEAR(m.mosaic.values(0, 2), 2100 / 1.1, 1e-3);  // both
  EXPECT_EQ(cv::countNonZero(m.flags & kSaturated), 0);
  EXPECT_EQ(m.flags(1, 0), kSingleSource);
  EXPECT_EQ(m.flags(1, 2), 0);
  stack[0].frame.dn(2, 4) = 16383;  // a half cell in the corner
  const MergedMosaic s = merge_exposures(stack, camera());
  EXPECT_EQ(cv::countNonZero(s.flags & kSaturated), 1);
  EXPECT_EQ(s.flags(2, 4), kSaturated);
}

/// 64 x 64 px of light `phi` as the camera sees it.
std::vector<RawExposure> noisy_stack(double phi, const std::vector<double>& seconds) {
  const SensorNoise noise = *camera().noise;
  RandomStream random(11, 1);
  std::vector<RawExposure> stack;
  for (const double t : seconds) {
    RawExposure e = flat(64, 64, 0, t);
    for (int r = 0; r < 64; ++r)
      for (int c = 0; c < 64; ++c) {
        const double k =
            noise.dn_per_electron[static_cast<std::size_t>(bayer_colour(e.frame.pattern, r, c))];
        const double electrons = random.poisson(phi * t / k) +
                                 noise.read_noise_e * random.normal() +
                                 noise.adc_noise * random.normal();
        e.frame.dn(r, c) = static_cast<std::uint16_t>(std::lround(512 + electrons * k));
      }
    stack.push_back(e);
  }
  return stack;
}

TEST(Merge, SigmaMatchesTheScatter) {
  MergeOptions options = camera();
  for (const auto estimator : {MergeEstimator::kPoisson, MergeEstimator::kFullNoise})
    for (const double phi : {30.0, 3000.0}) {
      options.estimator = estimator;
      const MergedMosaic m = merge_exposures(noisy_stack(phi, {0.01, 0.1}), options);
      double z2 = 0;
      for (int r = 0; r < 64; ++r)
        for (int c = 0; c < 64; ++c)
          z2 += std::pow((m.mosaic.values(r, c) - phi) / m.sigma_dn_s(r, c), 2) / 4096;
      // In the dark the full estimator weighs by the noisy estimate itself, and where that is too
      // low it believes in too small a deviation.
      const bool dark = estimator == MergeEstimator::kFullNoise && phi < 100;
      EXPECT_NEAR(std::sqrt(z2), 1, dark ? 0.15 : 0.06) << to_string(estimator) << " " << phi;
    }
}

// In deep shadows read and converter noise dominate, and the short frame only adds noise.
TEST(Merge, FullNoiseIsBetterInTheDark) {
  MergeOptions options = camera();
  const std::vector<RawExposure> stack = noisy_stack(30, {0.01, 0.1});
  const auto error = [&](MergeEstimator estimator) {
    options.estimator = estimator;
    return cv::norm(merge_exposures(stack, options).mosaic.values - cv::Scalar(30));
  };
  EXPECT_LT(error(MergeEstimator::kFullNoise), 0.95 * error(MergeEstimator::kPoisson));
}

// What is below two deviations is flagged: nearly all of a frame of no light, none of a bright one.
TEST(Merge, FlagsWhatIsTooDark) {
  const auto dark = merge_exposures(noisy_stack(0, {0.1}), camera());
  EXPECT_NEAR(cv::countNonZero(dark.flags & kUnderexposed) / 4096.0, 0.98, 0.02);
  const auto bright = merge_exposures(noisy_stack(3000, {0.1}), camera());
  EXPECT_EQ(cv::countNonZero(bright.flags & kUnderexposed), 0);
  MergeOptions unknown = camera();
  unknown.noise.reset();
  const auto no_model = merge_exposures(noisy_stack(0, {0.1}), unknown);
  EXPECT_TRUE(no_model.sigma_dn_s.empty());
  EXPECT_EQ(cv::countNonZero(no_model.flags & kUnderexposed), 0);
}

// Wide frames are merged in blocks, narrow ones in other blocks or cell by cell.
TEST(Merge, BlocksOfAnyWidthAgree) {
  std::vector<RawExposure> stack = noisy_stack(60000, {0.01, 0.1, 0.3});
  stack[2].gain = 2;
  stack[1].aperture_area = 0.5;
  for (int r = 0; r < 64; r += 3) stack[0].frame.dn(r, (7 * r) % 64) = 16383;
  MergeOptions options = camera();
  options.black_dn = {512, 510.25, 511.5, 513};
  const MergedMosaic whole = merge_exposures(stack, options);
  for (int x = 0; x < 64; x += 6) {
    std::vector<RawExposure> strip = stack;
    const cv::Range columns(x, std::min(x + 6, 64));
    for (RawExposure& e : strip) e.frame.dn = cv::Mat1w(e.frame.dn.colRange(columns));
    const MergedMosaic m = merge_exposures(strip, options);
    EXPECT_LT(cv::norm(m.mosaic.values, whole.mosaic.values.colRange(columns),
                       cv::NORM_INF | cv::NORM_RELATIVE),
              1e-6);
    EXPECT_LT(cv::norm(m.sigma_dn_s, whole.sigma_dn_s.colRange(columns),
                       cv::NORM_INF | cv::NORM_RELATIVE),
              1e-6);
    EXPECT_EQ(cv::norm(m.flags, whole.flags.colRange(columns), cv::NORM_INF), 0);
  }
}

TEST(Merge, GainAndApertureDivideOut) {
  std::vector<RawExposure> stack = {flat(8, 2, 612, 0.1), flat(8, 2, 1312, 0.1)};
  stack[1].gain = 4;
  stack[1].aperture_area = 2;
  const MergedMosaic m = merge_exposures(stack, camera());
  EXPECT_FLOAT_EQ(m.mosaic.values(0, 0), 1000);
}

void expect_refused(const std::vector<RawExposure>& stack, const std::string& part) {
  try {
    merge_exposures(stack, camera());
    FAIL() << part;
  } catch (const ArgumentError& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr(part));
  }
}

TEST(Merge, BadStacksAreRefusedByIndex) {
  expect_refused({}, "no exposures");
  expect_refused({flat(4, 4, 600, 1), flat(6, 4, 600, 2)}, "exposure 1 is 6 x 4");
  expect_refused({flat(4, 4, 600, 1), flat(4, 4, 600, 2), flat(4, 4, 600, 1)}, "exposure 2");
  expect_refused({flat(4, 4, 600, 1), flat(4, 4, 600, 0)}, "exposure 1");
  auto odd = flat(4, 4, 600, 2);
  odd.frame.pattern = BayerPattern::kGbrg;
  expect_refused({flat(4, 4, 600, 1), odd}, "pattern");
  auto no_gain = flat(4, 4, 600, 2);
  no_gain.gain = std::nan("");
  expect_refused({flat(4, 4, 600, 1), no_gain}, "exposure 1");
}

TEST(Merge, BadOptionsAreRefused) {
  const std::vector<RawExposure> stack = {flat(4, 4, 600, 1)};
  MergeOptions o = camera();
  o.black_dn[2] = 16383;
  EXPECT_THROW(merge_exposures(stack, o), ArgumentError);
  o = camera();
  o.estimator = MergeEstimator::kFullNoise;
  o.noise.reset();
  EXPECT_THROW(merge_exposures(stack, o), ArgumentError);
  o = camera();
  o.noise->adc_noise = -1;
  EXPECT_THROW(merge_exposures(stack, o), ArgumentError);
  o = camera();
  o.noise->dn_per_electron[1] = 0;
  EXPECT_THROW(merge_exposures(stack, o), ArgumentError);
  EXPECT_THROW(merge_estimator_from_string("debevec"), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
