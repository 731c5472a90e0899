#include "capture/deglare.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace wheatstone {
namespace {

// The vector is one colour plane; here all four of a mosaic are that plane.
TEST(Deglare, ReferenceVector) {
  std::ifstream file(WHEATSTONE_SOURCE_DIR "/tests/vectors/hdr/deglare.json");
  ASSERT_TRUE(file);
  const auto json = nlohmann::json::parse(file);
  const auto p = json["params_a1_b1_c1_a2_b2_c2"];
  const auto &in = json["even"]["input"], &expected = json["even"]["output"];
  const int rows = static_cast<int>(in.size()), columns = static_cast<int>(in[0].size());
  LinearMosaic mosaic{cv::Mat1f(2 * rows, 2 * columns)};
  for (int r = 0; r < 2 * rows; ++r)
    for (int c = 0; c < 2 * columns; ++c) mosaic.values(r, c) = in[r / 2][c / 2];
  const LinearMosaic out = remove_glare(mosaic, {p[0], p[1], p[2], p[3], p[4], p[5]});
  for (int r = 0; r < 2 * rows; ++r)
    for (int c = 0; c < 2 * columns; ++c) {
      const double e = expected[r / 2][c / 2];
      EXPECT_NEAR(out.values(r, c), e, 1e-6 * std::max(1.0, e)) << r << "," << c;
    }
}

// A mosaic of one frequency is scaled by 1 / MTF of just that frequency, in every colour plane.
TEST(Deglare, ScalesAFrequencyByItsMtf) {
  LinearMosaic mosaic{cv::Mat1f(32, 48)};
  const double cycles_per_plane_px = 3.0 / 24;
  for (int r = 0; r < 32; ++r)
    for (int c = 0; c < 48; ++c)
      mosaic.values(r, c) =
          static_cast<float>(100 + 20 * std::cos(2 * M_PI * cycles_per_plane_px * (c / 2)));
  const GlareMtf mtf{0.9, 0, 0.4, 0.1, 0, 2};
  const double rho = cycles_per_plane_px / 2;
  const double at_rho = 0.9 * std::exp(-std::pow(rho / 0.4, 2)) + 0.1 * std::exp(-rho * rho / 4);
  const LinearMosaic out = remove_glare(mosaic, mtf);
  for (int c = 0; c < 48; ++c)
    EXPECT_NEAR(out.values(5, c),
                100 + 20 / at_rho * std::cos(2 * M_PI * cycles_per_plane_px * (c / 2)), 1e-4);
}

TEST(Deglare, ConstantsOfOddSizesStay) {
  for (const cv::Size size : {cv::Size(2, 2), cv::Size(3, 5), cv::Size(13, 7)}) {
    const LinearMosaic mosaic{cv::Mat1f(size, 7.0f)};
    const LinearMosaic out = remove_glare(mosaic, {0.85, 0, 0.35, 0.15, 0, 1.5});
    EXPECT_LT(cv::norm(out.values, mosaic.values, cv::NORM_INF), 1e-5) << size;
  }
}

TEST(Deglare, AnMtfThatNoLensHasIsRefused) {
  const LinearMosaic mosaic{cv::Mat1f(8, 8, 1.0f)};
  EXPECT_THROW(remove_glare(mosaic, {0, 0, 1, 0, 0, 1}), ArgumentError);
  EXPECT_THROW(remove_glare(mosaic, {1, 0, 0, 0, 0, 1}), ArgumentError);
  EXPECT_THROW(remove_glare(mosaic, {1, 0, 1e-3, 0, 0, 1}), ArgumentError);
  EXPECT_THROW(remove_glare({cv::Mat1f(1, 8, 1.0f)}, {}), ArgumentError);
  // Not 1 for even light, which would scale all of it.
  EXPECT_THROW(remove_glare(mosaic, {9, 0, 1, 0.1, 0, 1}), ArgumentError);
  EXPECT_THROW(remove_glare(mosaic, {0.998, 0, 1, 0, 0, 1}), ArgumentError);
  EXPECT_NO_THROW(remove_glare(mosaic, {0.9995, 0, 1, 0, 0, 1}));
  EXPECT_THROW(remove_glare(mosaic, {NAN, 0, 1, 0, 0, 1}), ArgumentError);
  // The corner of the spectrum is at rho = sqrt(1/8): exp(-rho^2 / c^2) = 0.05 for c^2 = rho^2 /
  // ln 20.
  const double c = std::sqrt(0.125 / std::log(20.0));
  EXPECT_THROW(remove_glare(mosaic, {1, 0, 0.999 * c, 0, 0, 1}), ArgumentError);
  EXPECT_NO_THROW(remove_glare(mosaic, {1, 0, 1.001 * c, 0, 0, 1}));
}

}  // namespace
}  // namespace wheatstone
