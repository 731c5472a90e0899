#include "rendering/metrics/hdrvdp3/cosine_transform.h"

#include <gtest/gtest.h>

#include <numbers>

#include "planes.h"
#include "rendering/metrics/hdrvdp3/eye_optics.h"

namespace wheatstone {
namespace {

const cv::Size kSizes[] = {{1, 1}, {2, 1}, {1, 3}, {16, 12}, {13, 17}, {45, 64}, {97, 2}};

TEST(CosineTransform, IsItsDefinition) {
  for (const cv::Size size : kSizes) {
    const cv::Mat1d image = random_plane(size);
    cv::Mat1d expected(size);
    for (int l = 0; l < size.height; ++l)
      for (int k = 0; k < size.width; ++k) {
        double sum = 0;
        for (int m = 0; m < size.height; ++m)
          for (int n = 0; n < size.width; ++n)
            sum += image(m, n) * std::cos(std::numbers::pi * l * (2 * m + 1) / (2 * size.height)) *
                   std::cos(std::numbers::pi * k * (2 * n + 1) / (2 * size.width));
        expected(l, k) = sum;
      }
    cv::Mat1d spectrum = image.clone();
    cosine_transform(spectrum);
    EXPECT_LT(largest_difference(spectrum, expected), 1e-12 * cv::sum(image)[0]) << size;
  }
}

TEST(CosineTransform, InverseReturnsTheImage) {
  for (const cv::Size size : kSizes) {
    const cv::Mat1d image = random_plane(size);
    cv::Mat1d there_and_back = image.clone();
    cosine_transform(there_and_back);
    inverse_cosine_transform(there_and_back);
    EXPECT_LT(largest_difference(there_and_back, image), 1e-11) << size;
  }
}

TEST(EyeGlare, IsTheTransferFunctionOnTheMirroredImage) {
  constexpr double kPixelsPerDegree = 45;
  const auto mirrored = [](int i, int n) { return i < n ? i : 2 * n - 1 - i; };
  const auto gain = [](double y, double x) { return eye_mtf(std::hypot(y, x) * kPixelsPerDegree); };
  for (const cv::Size size : {cv::Size(40, 30), cv::Size(41, 30), cv::Size(29, 53)}) {
    const cv::Mat1d image = random_plane(size);
    cv::Mat1d seen = image.clone();
    EyeGlare(size, kPixelsPerDegree).apply(seen);
    EXPECT_LT(largest_difference(seen, filter_by_fourier(image, mirrored, gain)), 1e-10) << size;
    EXPECT_NEAR(cv::sum(seen)[0], cv::sum(image)[0], 1e-9 * cv::sum(image)[0]) << "light is lost";
  }
}

}  // namespace
}  // namespace wheatstone
