#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/error.h"
#include "core/png.h"
#include "rendering/metrics/comparable.h"
#include "rendering/metrics/pu21.h"
#include "rendering/metrics/pu21_rows.h"
#include "rendering/metrics/row_kernels.h"

namespace wheatstone {
namespace {

/// A mean squared error as PSNR in dB.
double decibel(double mse, double peak) {
  return mse == 0 ? std::numeric_limits<double>::infinity() : 10 * std::log10(peak * peak / mse);
}

/// Mean over the masked pixels of squared_error(row, column). Rows run in parallel; their sums are
/// added in order, so that the result does not depend on the threads.
template <class SquaredError>
double mean_squared(cv::Size size, const cv::Mat1b* mask, SquaredError squared_error) {
  std::vector<double> sums(size.height, 0.0);
  tbb::parallel_for(0, size.height, [&](int r) {
    for (int c = 0; c < size.width; ++c)
      if (!mask || (*mask)(r, c)) sums[r] += squared_error(r, c);
  });
  double sum = 0;
  for (const double s : sums) sum += s;
  return sum / (mask ? cv::countNonZero(*mask) : static_cast<double>(size.area()));
}

struct FastMean {
  double mse = 0;
  bool valid = true;  // false if light was not; mse is then meaningless
};

/// Mean over the masked pixels of the squared difference between encoded rows.
FastMean fast_mean_squared(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask,
                           detail::Pu21Source source) {
  const int width = test.width(), height = test.height();
  std::vector<double> sums(height, 0.0);
  std::vector<char> valid(height, 1);
  tbb::parallel_for(0, height, [&](int r) {
    std::vector<float> x(width), y(width);
    std::vector<double> squares(width, 0.0);
    const bool test_valid = source.encode(test.pixels[r], width, x.data());
    valid[r] = source.encode(reference.pixels[r], width, y.data()) && test_valid;
    detail::accumulate_squared_difference(x.data(), y.data(), width, squares.data(), best_simd());
    for (int c = 0; c < width; ++c)
      if (!mask || (*mask)(r, c)) sums[r] += squares[c];
  });
  FastMean out;
  for (int r = 0; r < height; ++r) {
    out.mse += sums[r];
    out.valid &= valid[r] != 0;
  }
  out.mse /= mask ? cv::countNonZero(*mask) : static_cast<double>(test.pixels.total());
  return out;
}

/// Mean over the channels of the squared difference in PU21 units.
double squared_pu21_difference(const cv::Vec3f& a, const cv::Vec3f& b) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    if (a[k] == b[k]) continue;
    const double d = pu21_encode(a[k]) - pu21_encode(b[k]);
    sum += d * d;
  }
  return sum / 3;
}

double luminance(const cv::Vec3f& p) {
  return kLuminanceWeights[0] * p[0] + kLuminanceWeights[1] * p[1] + kLuminanceWeights[2] * p[2];
}

/// Above this score the errors are so small that float rounding (about 1e-4 PU21 units) could move
/// the score by 1e-4 dB; such nearly equal pictures are scored again in double.
constexpr double kFastUpTo_db = 80;

template <class SquaredError>
double pu21_psnr(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask,
                 std::initializer_list<detail::Pu21Source> sources, SquaredError exactly) {
  detail::require_same_size(test, reference, mask);
  detail::require_not_black(test, reference);
  double mse = 0;
  for (const detail::Pu21Source source : sources) {
    const FastMean mean = fast_mean_squared(test, reference, mask, source);
    if (!mean.valid) detail::require_valid_light(test, reference);
    mse += mean.mse / static_cast<double>(sources.size());
  }
  const double fast = decibel(mse, kPu21Peak);
  if (fast < kFastUpTo_db) return fast;
  return decibel(mean_squared(test.pixels.size(), mask, exactly), kPu21Peak);
}

}  // namespace

double pu21_psnr_rgb(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask) {
  using detail::Pu21Source;
  return pu21_psnr(test, reference, mask,
                   {Pu21Source::channel(0), Pu21Source::channel(1), Pu21Source::channel(2)},
                   [&](int r, int c) {
                     return squared_pu21_difference(test.pixels(r, c), reference.pixels(r, c));
                   });
}

double pu21_psnr_luminance(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask) {
  return pu21_psnr(test, reference, mask, {detail::Pu21Source::luminance()}, [&](int r, int c) {
    const double d =
        pu21_encode(luminance(test.pixels(r, c))) - pu21_encode(luminance(reference.pixels(r, c)));
    return d * d;
  });
}

ScalarImage pu21_difference(const RgbImage& test, const RgbImage& reference) {
  detail::require_same_size(test, reference, nullptr);
  detail::require_valid_light(test, reference);
  ScalarImage out(test.width(), test.height());
  tbb::parallel_for(0, test.height(), [&](int r) {
    for (int c = 0; c < test.width(); ++c)
      out.pixels(r, c) = static_cast<float>(
          std::sqrt(squared_pu21_difference(test.pixels(r, c), reference.pixels(r, c))));
  });
  return out;
}

double srgb_psnr(const RgbImage& test, const RgbImage& reference, double white_cd_m2,
                 const cv::Mat1b* mask) {
  if (!(white_cd_m2 > 0) || !std::isfinite(white_cd_m2))
    throw ArgumentError(fmt::format("white of {} cd/m^2 is not positive", white_cd_m2),
                        "give the luminance of code 255");
  detail::require_same_size(test, reference, mask);
  detail::require_valid_light(test, reference);
  const cv::Mat3b a = to_srgb8(test, white_cd_m2), b = to_srgb8(reference, white_cd_m2);
  const auto squared_error = [&](int r, int c) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
      const double d = double(a(r, c)[k]) - b(r, c)[k];
      sum += d * d;
    }
    return sum / 3;
  };
  return decibel(mean_squared(a.size(), mask, squared_error), 255);
}

}  // namespace wheatstone
