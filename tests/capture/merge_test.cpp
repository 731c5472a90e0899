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

CameraProfile camera() {
  CameraProfile p;
  p.black_dn = 512;
  p.white_dn = 16383;
  p.dn_per_electron = {0.42, 0.38, 0.39};
  p.read_noise_e = 0.7;
  p.adc_noise = 3;
  return p;
}

RawExposure flat(int width, int height, int dn, double seconds) {
  return {{cv::Mat1w(height, width, static_cast<std::uint16_t>(dn)), BayerPattern::kRggb},
          Duration::of(seconds)};
}

TEST(Merge, ReferenceVectors) {
  std::ifstream file(WHEATSTONE_SOURCE_DIR "/tests/vectors/merge_stacks.json");
  ASSERT_TRUE(file);
  const auto json = nlohmann::json::parse(file);
  for (const auto& v : json["cases"]) {
    const std::string name = v["name"];
    CameraProfile p;
    p.black_dn = v["black_level"];
    p.white_dn = (1 << v["bits"].get<int>()) - 1;
    p.pattern = bayer_pattern_from_string(v["pattern"]);
    const int rows = v["rows"], cols = v["cols"];
    std::vector<RawExposure> stack;
    for (std::size_t i = 0; i < v["images"].size(); ++i) {
      RawExposure e{{cv::Mat1w(rows, cols), p.pattern},
                    Duration::of(v["exposure_s"][i].get<double>()),
                    v["gain"][i].get<double>()};
      for (int r = 0; r < rows; ++r)
        for (int c = 0; c < cols; ++c) e.frame.dn(r, c) = v["images"][i][r][c].get<std::uint16_t>();
      stack.push_back(e);
    }
    const MergedMosaic m = merge_exposures(stack, p);
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < cols; ++c) {
        const double expected = v["expected_poisson_estimator"][r][c];
        EXPECT_NEAR(m.mosaic.values(r, c), expected, 1e-6 * std::max(1.0, std::abs(expected)))
            << name << " " << r << "," << c;
        EXPECT_EQ(m.saturated(r, c) == 0, v["unsaturated_in_shortest"][r][c].get<int>() == 1)
            << name << " " << r << "," << c;
      }
  }
}

TEST(Merge, OneSaturatedPixelExcludesItsCell) {
  std::vector<RawExposure> stack = {flat(5, 3, 612, 0.1), flat(5, 3, 2512, 1)};
  stack[1].frame.dn(1, 1) = 16383;
  const MergedMosaic m = merge_exposures(stack, camera());
  EXPECT_FLOAT_EQ(m.mosaic.values(0, 0), 1000);          // shortest alone
  EXPECT_NEAR(m.mosaic.values(0, 2), 2100 / 1.1, 1e-3);  // both
  EXPECT_EQ(cv::countNonZero(m.saturated), 0);
  stack[0].frame.dn(2, 4) = 16383;  // a half cell in the corner
  const MergedMosaic s = merge_exposures(stack, camera());
  EXPECT_EQ(cv::countNonZero(s.saturated), 1);
  EXPECT_EQ(s.saturated(2, 4), 255);
}

TEST(Merge, SigmaMatchesTheScatter) {
  const CameraProfile p = camera();
  RandomStream random(11, 1);
  std::vector<RawExposure> stack = {flat(64, 64, 0, 0.01), flat(64, 64, 0, 0.1)};
  const double phi = 3000;
  for (auto& e : stack)
    for (int r = 0; r < 64; ++r)
      for (int c = 0; c < 64; ++c) {
        const double k =
            p.dn_per_electron[static_cast<std::size_t>(bayer_colour(e.frame.pattern, r, c))];
        const double electrons = random.poisson(phi * e.exposure.value() / k) +
                                 p.read_noise_e * random.normal() + p.adc_noise * random.normal();
        e.frame.dn(r, c) = static_cast<std::uint16_t>(std::lround(512 + electrons * k));
      }
  const MergedMosaic m = merge_exposures(stack, p);
  double z2 = 0;
  for (int r = 0; r < 64; ++r)
    for (int c = 0; c < 64; ++c)
      z2 += std::pow((m.mosaic.values(r, c) - phi) / m.sigma_dn_s(r, c), 2) / 4096;
  EXPECT_NEAR(std::sqrt(z2), 1, 0.06);
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
}

}  // namespace
}  // namespace wheatstone
