#include "rendering/metrics/pu21.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "vectors.h"

namespace wheatstone {
namespace {

TEST(Pu21, EncodesAndDecodesLikeTheReference) {
  const auto vectors = read_vectors("pu21_encode.json")["variants"];
  const std::pair<const char*, Pu21Variant> variants[] = {
      {"banding", Pu21Variant::kBanding},
      {"banding_glare", Pu21Variant::kBandingGlare},
      {"peaks", Pu21Variant::kPeaks},
      {"peaks_glare", Pu21Variant::kPeaksGlare}};
  for (const auto& [name, variant] : variants)
    for (const auto& row : vectors.at(name)) {
      const double light = row[0], encoded = row[1], decoded = row[2];
      // The vectors are written with 10 (light) and 12 digits.
      EXPECT_NEAR(pu21_encode(light, variant), encoded, 2e-7 + 1e-9 * encoded) << name;
      EXPECT_NEAR(pu21_decode(encoded, variant), decoded, 1e-7 * decoded) << name;
    }
}

TEST(Pu21, PsnrLikeTheReference) {
  int compared = 0;
  const auto file = read_vectors("pu21_metrics.json");
  for (const auto& c : file["cases"]) {
    const std::string reference = c["reference"], test = c["test"];
    const RgbImage a = vector_image(test), b = vector_image(reference);
    EXPECT_NEAR(pu21_psnr_rgb(a, b), c["pu_psnr_rgb_db"].get<double>(), 1e-4) << test;
    EXPECT_NEAR(pu21_psnr_luminance(a, b), c["pu_psnr_luminance_db"].get<double>(), 1e-4) << test;
    ++compared;
  }
  EXPECT_EQ(compared, 12);
}

TEST(Pu21, DifferenceMapAndMaskAgreeWithTheScore) {
  const RgbImage a = vector_image("img/a_patch.pfm"), b = vector_image("img/a_ref.pfm");
  const ScalarImage d = pu21_difference(a, b);
  const double mse = cv::norm(d.pixels, cv::NORM_L2SQR) / static_cast<double>(d.pixels.total());
  EXPECT_NEAR(10 * std::log10(256 * 256 / mse), pu21_psnr_rgb(a, b), 1e-4);
  const cv::Mat1b same = d.pixels == 0, differs = d.pixels > 0;
  EXPECT_EQ(pu21_psnr_rgb(a, b, &same), std::numeric_limits<double>::infinity());
  EXPECT_LT(pu21_psnr_rgb(a, b, &differs), pu21_psnr_rgb(a, b));
}

TEST(Pu21, SrgbPsnrOfOneCodeStep) {
  RgbImage a(4, 3), b(4, 3);
  a.pixels.setTo(cv::Scalar::all(100));
  b.pixels.setTo(cv::Scalar::all(200));  // white clips to 255 in both
  EXPECT_EQ(srgb_psnr(a, b, 100), std::numeric_limits<double>::infinity());
  b.pixels.setTo(cv::Scalar::all(0));
  EXPECT_NEAR(srgb_psnr(a, b, 100), 0, 1e-12);
}

TEST(Pu21, ImpossibleImagesAreRefused) {
  RgbImage a(4, 3), b(4, 3), other(3, 4);
  EXPECT_THROW(pu21_psnr_rgb(a, other), ArgumentError);
  EXPECT_THROW(pu21_psnr_rgb(RgbImage(), RgbImage()), ArgumentError);
  const cv::Mat1b empty_mask = cv::Mat1b::zeros(3, 4), wrong_mask = cv::Mat1b::ones(4, 3);
  EXPECT_THROW(pu21_psnr_rgb(a, b, &empty_mask), ArgumentError);
  EXPECT_THROW(pu21_psnr_rgb(a, b, &wrong_mask), ArgumentError);
  EXPECT_THROW(srgb_psnr(a, b, 0), ArgumentError);
  for (const float bad :
       {-1.0f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    a.pixels(1, 2)[1] = bad;
    EXPECT_THROW(pu21_psnr_rgb(a, b), ArgumentError);
    EXPECT_THROW(pu21_difference(b, a), ArgumentError);
    EXPECT_THROW(srgb_psnr(a, b, 100), ArgumentError);
  }
}

}  // namespace
}  // namespace wheatstone
