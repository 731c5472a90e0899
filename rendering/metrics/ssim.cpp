#include "rendering/metrics/ssim.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "core/error.h"
#include "rendering/metrics/comparable.h"
#include "rendering/metrics/pu21_rows.h"
#include "rendering/metrics/ssim_means.h"

namespace wheatstone {
namespace {

using detail::PairedRows;
using detail::Pu21Source;
using detail::ssim_means;
using detail::SsimMeans;

/// Mask to weights, or nothing without a mask.
std::optional<cv::Mat1f> weights_of(const cv::Mat1b* mask) {
  if (!mask) return std::nullopt;
  cv::Mat1f out;
  cv::Mat(*mask != 0).convertTo(out, CV_32F, 1 / 255.0);
  return out;
}

PairedRows pu21_rows(const RgbImage& test, const RgbImage& reference, Pu21Source source) {
  return [&test, &reference, source](int row, int column, int count, float* x, float* y) {
    const bool test_valid = source.encode(test.pixels[row] + column, count, x);
    return source.encode(reference.pixels[row] + column, count, y) && test_valid;
  };
}

/// Mean over the sources of score(source), after what all scores ask of their pictures.
template <class Score>
double mean_score(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask,
                  std::initializer_list<Pu21Source> sources, Score score) {
  detail::require_same_size(test, reference, mask);
  detail::require_not_black(test, reference);
  double sum = 0;
  for (const Pu21Source source : sources) sum += score(source);
  return sum / static_cast<double>(sources.size());
}

double ssim(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask,
            ScalarImage* map, std::initializer_list<Pu21Source> sources) {
  if (map) *map = ScalarImage(test.width(), test.height());
  return mean_score(test, reference, mask, sources, [&](Pu21Source source) {
    const std::optional<cv::Mat1f> weights = weights_of(mask);
    cv::Mat1f source_map(map ? test.pixels.size() : cv::Size());
    const SsimMeans means = ssim_means(test.pixels.size(), pu21_rows(test, reference, source),
                                       weights ? &*weights : nullptr, map ? &source_map : nullptr);
    if (!means.valid) detail::require_valid_light(test, reference);
    if (map) map->pixels += source_map / static_cast<double>(sources.size());
    return means.ssim;
  });
}

/// Means of 2x2 pixels; an odd last row or column is repeated.
cv::Mat1f halved(const cv::Mat1f& plane) {
  cv::Mat1f out((plane.rows + 1) / 2, (plane.cols + 1) / 2);
  tbb::parallel_for(0, out.rows, [&](int r) {
    const float* above = plane[2 * r];
    const float* below = plane[std::min(2 * r + 1, plane.rows - 1)];
    for (int c = 0; c < out.cols; ++c) {
      const int left = 2 * c, right = std::min(2 * c + 1, plane.cols - 1);
      out(r, c) = 0.25F * ((above[left] + above[right]) + (below[left] + below[right]));
    }
  });
  return out;
}

/// PU21 values of a whole picture.
cv::Mat1f encoded(const RgbImage& image, Pu21Source source, bool& valid) {
  cv::Mat1f out(image.pixels.size());
  std::vector<char> row_valid(static_cast<std::size_t>(image.height()), 1);
  tbb::parallel_for(0, image.height(), [&](int r) {
    row_valid[r] = source.encode(image.pixels[r], image.width(), out[r]);
  });
  for (const char v : row_valid) valid &= v != 0;
  return out;
}

double ms_ssim(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask,
               std::initializer_list<Pu21Source> sources) {
  constexpr std::array<double, 5> kExponents = {0.0448, 0.2856, 0.3001, 0.2363, 0.1333};
  return mean_score(test, reference, mask, sources, [&](Pu21Source source) {
    if (std::min(test.width(), test.height()) < kMsSsimMinSide_px)
      throw ArgumentError(
          fmt::format("{}x{} pixels are too few for the five scales of MS-SSIM", test.width(),
                      test.height()),
          fmt::format("give pictures of at least {0}x{0} pixels, or use SSIM", kMsSsimMinSide_px));
    bool valid = true;
    cv::Mat1f x = encoded(test, source, valid), y = encoded(reference, source, valid);
    if (!valid) detail::require_valid_light(test, reference);
    std::optional<cv::Mat1f> weights = weights_of(mask);
    double product = 1;
    for (std::size_t scale = 0; scale < kExponents.size(); ++scale) {
      if (scale > 0) {
        x = halved(x);
        y = halved(y);
        if (weights) weights = halved(*weights);
      }
      const auto rows = [&](int row, int column, int count, float* a, float* b) {
        std::copy_n(x[row] + column, count, a);
        std::copy_n(y[row] + column, count, b);
        return true;
      };
      const SsimMeans means = ssim_means(x.size(), rows, weights ? &*weights : nullptr);
      const double factor = scale + 1 < kExponents.size() ? means.contrast_structure : means.ssim;
      product *= std::pow(std::max(factor, 0.0), kExponents[scale]);
    }
    return product;
  });
}

}  // namespace

double pu21_ssim_luminance(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask,
                           ScalarImage* map) {
  return ssim(test, reference, mask, map, {Pu21Source::luminance()});
}

double pu21_ssim_rgb(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask,
                     ScalarImage* map) {
  return ssim(test, reference, mask, map,
              {Pu21Source::channel(0), Pu21Source::channel(1), Pu21Source::channel(2)});
}

double pu21_ms_ssim_luminance(const RgbImage& test, const RgbImage& reference,
                              const cv::Mat1b* mask) {
  return ms_ssim(test, reference, mask, {Pu21Source::luminance()});
}

double pu21_ms_ssim_rgb(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask) {
  return ms_ssim(test, reference, mask,
                 {Pu21Source::channel(0), Pu21Source::channel(1), Pu21Source::channel(2)});
}

}  // namespace wheatstone
