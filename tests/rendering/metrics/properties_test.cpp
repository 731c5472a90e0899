// What every similarity must do, whatever its formula: be best for equal pictures, treat the two
// alike, and fall as the damage grows.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/random.h"
#include "rendering/metrics/pu21.h"
#include "rendering/metrics/ssim.h"
#include "vectors.h"

namespace wheatstone {
namespace {

struct Similarity {
  const char* name;
  double (*score)(const RgbImage& test, const RgbImage& reference);
  double best;
};

void PrintTo(const Similarity& similarity, std::ostream* out) {
  *out << similarity.name;
}

class EverySimilarity : public ::testing::TestWithParam<Similarity> {
 protected:
  double score(const RgbImage& test) const { return GetParam().score(test, reference_); }
  const RgbImage reference_ = vector_image("img/b_ref.pfm");
};

TEST_P(EverySimilarity, EqualPicturesScoreBest) {
  EXPECT_EQ(score(reference_), GetParam().best);
  EXPECT_LT(score(vector_image("img/b_quant12.pfm")), GetParam().best);
}

TEST_P(EverySimilarity, IsSymmetric) {
  const RgbImage test = vector_image("img/b_blur20.pfm");
  EXPECT_NEAR(score(test), GetParam().score(reference_, test), 1e-6);
}

TEST_P(EverySimilarity, FallsWithGrowingNoise) {
  double last = GetParam().best;
  for (const double sigma : {0.01, 0.03, 0.1, 0.3}) {
    RandomStream random(9, 0);
    RgbImage test(reference_.pixels.clone());
    for (cv::Vec3f& p : test.pixels)
      for (int k = 0; k < 3; ++k) p[k] *= static_cast<float>(std::exp(sigma * random.normal()));
    const double now = score(test);
    EXPECT_LT(now, last) << sigma;
    last = now;
  }
}

TEST_P(EverySimilarity, FallsWithGrowingBlur) {
  double last = GetParam().best;
  for (const double sigma_px : {0.5, 1.0, 2.0, 4.0}) {
    RgbImage test;
    cv::GaussianBlur(reference_.pixels, test.pixels, {}, sigma_px);
    const double now = score(test);
    EXPECT_LT(now, last) << sigma_px;
    last = now;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Metrics, EverySimilarity,
    ::testing::Values(
        Similarity{"PsnrRgb",
                   [](const RgbImage& a, const RgbImage& b) { return pu21_psnr_rgb(a, b); },
                   std::numeric_limits<double>::infinity()},
        Similarity{"PsnrY",
                   [](const RgbImage& a, const RgbImage& b) { return pu21_psnr_luminance(a, b); },
                   std::numeric_limits<double>::infinity()},
        Similarity{"SsimRgb",
                   [](const RgbImage& a, const RgbImage& b) { return pu21_ssim_rgb(a, b); }, 1},
        Similarity{"SsimY",
                   [](const RgbImage& a, const RgbImage& b) { return pu21_ssim_luminance(a, b); },
                   1},
        Similarity{"MsSsimRgb",
                   [](const RgbImage& a, const RgbImage& b) { return pu21_ms_ssim_rgb(a, b); }, 1},
        Similarity{
            "MsSsimY",
            [](const RgbImage& a, const RgbImage& b) { return pu21_ms_ssim_luminance(a, b); }, 1}),
    [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace wheatstone
