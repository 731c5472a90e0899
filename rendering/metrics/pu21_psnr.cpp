#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
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

enum class PsnrChannels { kRgb, kLuminance };

struct FastMean {
  double mse = 0;
  bool valid = true;  // false if light was not; mse is then meaningless
};

/// Mean over the masked pixels of the squared difference between encoded rows: of the luminance,
/// or of R, G and B, which are encoded alike and so taken as one row of samples.
FastMean fast_mean_squared(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask,
                           PsnrChannels channels) {
  constexpr int kStripRows = 32;
  const int width = test.width(), height = test.height();
  const int per_pixel = channels == PsnrChannels::kRgb ? 3 : 1, samples = per_pixel * width;
  const Simd simd = best_simd();
  const auto encode = [&](const RgbImage& image, int row, float* pu21) {
    const cv::Vec3f* light = image.pixels[row];
    if (channels == PsnrChannels::kLuminance)
      return detail::Pu21Source::luminance().encode(light, width, pu21);
    return detail::pu21_encode_span(detail::pu21_table(Pu21Variant::kBandingGlare), light->val,
                                    static_cast<std::size_t>(samples), pu21, simd);
  };
  std::vector<FastMean> strips((height + kStripRows - 1) / kStripRows);
  tbb::parallel_for(std::size_t{0}, strips.size(), [&](std::size_t i) {
    FastMean& strip = strips[i];
    std::vector<float> x(samples), y(samples);
    std::vector<double> squares(samples, 0.0);  // of each column
    const int begin = static_cast<int>(i) * kStripRows;
    for (int r = begin; r < std::min(begin + kStripRows, height); ++r) {
      strip.valid &= encode(test, r, x.data());
      strip.valid &= encode(reference, r, y.data());
      if (mask)
        for (int c = 0; c < width; ++c)
          if (!(*mask)(r, c)) std::copy_n(&x[c * per_pixel], per_pixel, &y[c * per_pixel]);
      detail::accumulate_squared_difference(x.data(), y.data(), samples, squares.data(), simd);
    }
    strip.mse = std::accumulate(squares.begin(), squares.end(), 0.0);
  });
  FastMean out;
  for (const FastMean& strip : strips) {  // in order, whichever thread did them
    out.mse += strip.mse;
    out.valid &= strip.valid;
  }
  out.mse /=
      per_pixel * (mask ? cv::countNonZero(*mask) : static_cast<double>(test.pixels.total()));
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
                 PsnrChannels channels, SquaredError exactly) {
  detail::require_same_size(test, reference, mask);
  detail::require_not_black(test, reference);
  const FastMean fast = fast_mean_squared(test, reference, mask, channels);
  if (!fast.valid) detail::require_valid_light(test, reference);
  if (const double db = decibel(fast.mse, kPu21Peak); db < kFastUpTo_db) return db;
  return decibel(mean_squared(test.pixels.size(), mask, exactly), kPu21Peak);
}

}  // namespace

double pu21_psnr_rgb(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask) {
  return pu21_psnr(test, reference, mask, PsnrChannels::kRgb, [&](int r, int c) {
    return squared_pu21_difference(test.pixels(r, c), reference.pixels(r, c));
  });
}

double pu21_psnr_luminance(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask) {
  return pu21_psnr(test, reference, mask, PsnrChannels::kLuminance, [&](int r, int c) {
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
