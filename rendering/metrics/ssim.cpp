#include "rendering/metrics/ssim.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
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
  return [&test, &reference, source](int row, float* x, float* y) {
    const bool test_valid = source.encode(test.pixels[row], test.width(), x);
    return source.encode(reference.pixels[row], reference.width(), y) && test_valid;
  };
}

PairedRows plane_rows(const cv::Mat1f& test, const cv::Mat1f& reference) {
  return [&test, &reference](int row, float* x, float* y) {
    std::copy_n(test[row], test.cols, x);
    std::copy_n(reference[row], reference.cols, y);
    return true;
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

/// Means of 2x2 pixels of two rows (the same one twice for an odd last row); an odd last column is
/// repeated.
void halve(const float* above, const float* below, int count, float* out) {
  for (int c = 0; c < (count + 1) / 2; ++c) {
    const int left = 2 * c, right = std::min(2 * c + 1, count - 1);
    out[c] = 0.25F * ((above[left] + above[right]) + (below[left] + below[right]));
  }
}

cv::Mat1f halved(const cv::Mat1f& plane) {
  cv::Mat1f out((plane.rows + 1) / 2, (plane.cols + 1) / 2);
  for (int r = 0; r < out.rows; ++r)
    halve(plane[2 * r], plane[std::min(2 * r + 1, plane.rows - 1)], plane.cols, out[r]);
  return out;
}

struct Planes {
  cv::Mat1f test, reference;
};

/// The next coarser scale.
Planes halved(cv::Size size, const PairedRows& rows) {
  const cv::Size half((size.width + 1) / 2, (size.height + 1) / 2);
  Planes out{cv::Mat1f(half), cv::Mat1f(half)};
  tbb::parallel_for(tbb::blocked_range<int>(0, half.height), [&](const auto& range) {
    cv::Mat1f above(2, size.width), below(2, size.width);
    for (int r = range.begin(); r < range.end(); ++r) {
      rows(2 * r, above[0], above[1]);
      rows(std::min(2 * r + 1, size.height - 1), below[0], below[1]);
      halve(above[0], below[0], size.width, out.test[r]);
      halve(above[1], below[1], size.width, out.reference[r]);
    }
  });
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
    cv::Size size = test.pixels.size();
    PairedRows rows = pu21_rows(test, reference, source);
    Planes planes;
    std::optional<cv::Mat1f> weights = weights_of(mask);
    double product = 1;
    for (std::size_t scale = 0; scale < kExponents.size(); ++scale) {
      if (scale > 0) {
        planes = halved(size, rows);
        size = planes.test.size();
        rows = plane_rows(planes.test, planes.reference);
        if (weights) weights = halved(*weights);
      }
      const SsimMeans means = ssim_means(size, rows, weights ? &*weights : nullptr);
      if (!means.valid) detail::require_valid_light(test, reference);
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
