#include "rendering/metrics/hdrvdp3/gaussian_blur.h"

#include <gtest/gtest.h>

#include <numbers>

#include "planes.h"

namespace wheatstone {
namespace {

cv::Mat1d blurred(const cv::Mat1d& image, double sigma_px, BlurBorder border) {
  cv::Mat1d out = image.clone();
  gaussian_blur(out, sigma_px, border);
  return out;
}

int replicate(int i, int n) {
  return std::clamp(i, 0, n - 1);
}
int zero(int i, int n) {
  return i >= 0 && i < n ? i : -1;
}

TEST(GaussianBlur, WideIsTheFourierDefinition) {
  // Sizes below the reach of the kernel, which then comes around more than once, too.
  for (const cv::Size size : {cv::Size(80, 64), cv::Size(61, 45), cv::Size(13, 17)})
    for (const double sigma : {4.3, 7.445, 14.0}) {
      const cv::Mat1d image = random_plane(size);
      const auto gain = [&](double y, double x) {
        const double w = 2 * std::numbers::pi * std::hypot(y, x);
        return std::exp(-0.5 * sigma * sigma * w * w);
      };
      EXPECT_LT(largest_difference(blurred(image, sigma, BlurBorder::kReplicate),
                                   filter_by_fourier(image, replicate, gain)),
                1e-8 * 1000)
          << size << " sigma " << sigma;
      EXPECT_LT(largest_difference(blurred(image, sigma, BlurBorder::kZero),
                                   filter_by_fourier(image, zero, gain)),
                1e-8 * 1000)
          << size << " sigma " << sigma;
    }
}

TEST(GaussianBlur, NarrowIsTheTruncatedKernel) {
  const cv::Mat1d image = random_plane({37, 29});
  // Odd sizes near 6 sigma.
  const std::pair<double, int> sigmas[] = {{0.66, 5}, {1.0, 7}, {2.5, 15}, {4.29, 27}};
  for (const auto& [sigma, side] : sigmas)
    for (const BlurBorder border : {BlurBorder::kReplicate, BlurBorder::kZero}) {
      const int radius = side / 2;
      cv::Mat1d expected(image.size());
      for (int r = 0; r < image.rows; ++r)
        for (int c = 0; c < image.cols; ++c) {
          double sum = 0, weights = 0;
          for (int j = -radius; j <= radius; ++j)
            for (int i = -radius; i <= radius; ++i) {
              const double weight = std::exp(-0.5 * (i * i + j * j) / (sigma * sigma));
              const auto at = border == BlurBorder::kZero ? zero : replicate;
              const int y = at(r + j, image.rows), x = at(c + i, image.cols);
              weights += weight;
              if (y >= 0 && x >= 0) sum += weight * image(y, x);
            }
          expected(r, c) = sum / weights;
        }
      EXPECT_LT(largest_difference(blurred(image, sigma, border), expected), 1e-10) << sigma;
    }
}

TEST(GaussianBlur, LeavesAConstantAlone) {
  const cv::Mat1d image(20, 33, 7.0);
  for (const double sigma : {0.5, 4.0, 20.0})
    EXPECT_LT(largest_difference(blurred(image, sigma, BlurBorder::kReplicate), image), 1e-12);
}

}  // namespace
}  // namespace wheatstone
