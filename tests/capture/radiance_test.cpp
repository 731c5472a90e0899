#include "capture/radiance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/random.h"

namespace wheatstone {
namespace {

CameraProfile camera_with_crosstalk() {
  CameraProfile camera;
  camera.dn_per_cd_m2_s = 900;
  camera.camera_from_bt709 << 0.7, 0.25, 0.05, 0.1, 0.85, 0.05, 0.02, 0.2, 0.6;
  return camera;
}

/// 2 x 2 mosaic of saturated red light; its photosites scatter by what sigma_dn_s says.
MergedMosaic cell(BayerPattern pattern, std::uint64_t seed) {
  MergedMosaic m{{cv::Mat1f(2, 2), pattern}, cv::Mat1f(2, 2), cv::Mat1b(2, 2, std::uint8_t{0})};
  const CameraProfile camera = camera_with_crosstalk();
  const Eigen::Vector3d dn_s =
      camera.dn_per_cd_m2_s * camera.camera_from_bt709 * Eigen::Vector3d(60, 4, 1);
  RandomStream random(11, seed);
  for (int i = 0; i < 4; ++i) {
    const int colour = bayer_colour(pattern, i / 2, i % 2);
    m.sigma_dn_s(i / 2, i % 2) = static_cast<float>(20 * std::sqrt(dn_s[colour]) / (1 + i));
    m.mosaic.values(i / 2, i % 2) =
        static_cast<float>(dn_s[colour] + m.sigma_dn_s(i / 2, i % 2) * random.normal());
  }
  return m;
}

// Of 20 000 cells the luminance scatters by what is said of each: within 2 % (4 standard errors).
TEST(LuminanceDeviation, IsTheSpreadOfACellsLuminance) {
  constexpr int kCells = 20000;
  const CameraProfile camera = camera_with_crosstalk();
  for (const BayerPattern pattern :
       {BayerPattern::kRggb, BayerPattern::kBggr, BayerPattern::kGrbg, BayerPattern::kGbrg}) {
    double sum = 0, squares = 0, said = 0;
    for (int i = 0; i < kCells; ++i) {
      const MergedMosaic m = cell(pattern, static_cast<std::uint64_t>(i));
      cv::Vec3f colours(0, 0, 0);
      for (int k = 0; k < 4; ++k) {
        const int colour = bayer_colour(pattern, k / 2, k % 2);
        colours[colour] += m.mosaic.values(k / 2, k % 2) / (colour == 1 ? 2.0F : 1.0F);
      }
      const double y = luminance_cd_m2(to_radiance(cv::Mat3f(1, 1, colours), camera)).pixels(0, 0);
      sum += y;
      squares += y * y;
      const cv::Mat1f deviation = luminance_deviation(m, camera);
      said = deviation(0, 0);
      for (const float d : deviation) EXPECT_EQ(d, deviation(0, 0));
    }
    const double mean = sum / kCells;
    EXPECT_NEAR(std::sqrt(squares / kCells - mean * mean) / said, 1, 0.02) << to_string(pattern);
  }
}

TEST(LuminanceDeviation, OddEdgesAndMissingDeviations) {
  MergedMosaic m{{cv::Mat1f(3, 5, 100.0F)}, cv::Mat1f(3, 5), cv::Mat1b(3, 5, std::uint8_t{0})};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 5; ++c) m.sigma_dn_s(r, c) = static_cast<float>(1 + c / 2);
  const CameraProfile camera = camera_with_crosstalk();
  const cv::Mat1f out = luminance_deviation(m, camera);
  ASSERT_EQ(out.size(), m.sigma_dn_s.size());
  EXPECT_FLOAT_EQ(out(0, 2), 2 * out(0, 0));
  for (int c = 0; c < 5; ++c) EXPECT_EQ(out(2, c), out(0, c));
  EXPECT_EQ(out(0, 4), out(0, 3)) << "half a cell has its neighbour's";
  m.sigma_dn_s.release();
  EXPECT_TRUE(luminance_deviation(m, camera).empty());
  m.sigma_dn_s.create(1, 5);
  EXPECT_THROW(luminance_deviation(m, camera), ArgumentError);
}

TEST(LuminanceDeviation, ImpossibleProfilesAreRefused) {
  CameraProfile camera = camera_with_crosstalk();
  camera.camera_from_bt709.setZero();
  EXPECT_THROW(luminance_deviation(cell(BayerPattern::kRggb, 1), camera), ArgumentError);
  EXPECT_THROW(to_radiance(cv::Mat3f(1, 1), camera), ArgumentError);
  camera = camera_with_crosstalk();
  camera.dn_per_cd_m2_s = 0;
  EXPECT_THROW(luminance_deviation(cell(BayerPattern::kRggb, 1), camera), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
