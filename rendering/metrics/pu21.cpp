#include "rendering/metrics/pu21.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/png.h"

namespace wheatstone {
namespace {

struct Parameters {
  double p1, p2, p3, p4, p5, p6, p7;
};

const Parameters& parameters(Pu21Variant variant) {
  static constexpr std::array<Parameters, 4> kParameters = {{
      {1.070275272, 0.4088273932, 0.153224308, 0.2520326168, 1.063512885, 1.14115047, 521.4527484},
      {0.353487901, 0.3734658629, 8.277049286e-05, 0.9062562627, 0.09150303166, 0.9099517204,
       596.3148142},
      {1.043882782, 0.6459495343, 0.3194584211, 0.374025247, 1.114783422, 1.095360363, 384.9217577},
      {816.885024, 1479.463946, 0.001253215609, 0.9329636822, 0.06746643971, 1.573435413,
       419.6006374},
  }};
  return kParameters[static_cast<std::size_t>(variant)];
}

void require_comparable(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask) {
  if (test.empty() || test.pixels.size() != reference.pixels.size())
    throw ArgumentError(
        fmt::format("the test image has {}x{} pixels, the reference {}x{}", test.width(),
                    test.height(), reference.width(), reference.height()),
        "compare pictures of the same size");
  if (mask && mask->size() != test.pixels.size())
    throw ArgumentError(fmt::format("the mask has {}x{} pixels, the images {}x{}", mask->cols,
                                    mask->rows, test.width(), test.height()),
                        "give a mask of the images' size");
  require_valid_radiance(test, "the test image");
  require_valid_radiance(reference, "the reference image");
}

/// Mean over the masked pixels of squared_error(row, column), as PSNR in dB.
template <class SquaredError>
double psnr_db(cv::Size size, const cv::Mat1b* mask, double peak, SquaredError squared_error) {
  double sum = 0;
  std::int64_t count = 0;
  for (int r = 0; r < size.height; ++r)
    for (int c = 0; c < size.width; ++c) {
      if (mask && !(*mask)(r, c)) continue;
      sum += squared_error(r, c);
      ++count;
    }
  if (count == 0) throw ArgumentError("the mask selects no pixel", "give a mask that selects some");
  if (sum == 0) return std::numeric_limits<double>::infinity();
  return 10 * std::log10(peak * peak * static_cast<double>(count) / sum);
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

}  // namespace

double pu21_encode(double luminance_cd_m2, Pu21Variant variant) {
  const Parameters& p = parameters(variant);
  const double y = std::pow(std::clamp(luminance_cd_m2, kPu21MinCdM2, kPu21MaxCdM2), p.p4);
  const double v = std::pow((p.p1 + p.p2 * y) / (1 + p.p3 * y), p.p5);
  return std::max(p.p7 * (v - p.p6), 0.0);
}

double pu21_decode(double pu21, Pu21Variant variant) {
  const Parameters& p = parameters(variant);
  const double v = std::pow(std::max(pu21 / p.p7 + p.p6, 0.0), 1 / p.p5);
  return std::pow(std::max(v - p.p1, 0.0) / (p.p2 - p.p3 * v), 1 / p.p4);
}

double pu21_psnr_rgb(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask) {
  require_comparable(test, reference, mask);
  return psnr_db(test.pixels.size(), mask, kPu21Peak, [&](int r, int c) {
    return squared_pu21_difference(test.pixels(r, c), reference.pixels(r, c));
  });
}

double pu21_psnr_luminance(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask) {
  require_comparable(test, reference, mask);
  return psnr_db(test.pixels.size(), mask, kPu21Peak, [&](int r, int c) {
    const double d =
        pu21_encode(luminance(test.pixels(r, c))) - pu21_encode(luminance(reference.pixels(r, c)));
    return d * d;
  });
}

ScalarImage pu21_difference(const RgbImage& test, const RgbImage& reference) {
  require_comparable(test, reference, nullptr);
  ScalarImage out(test.width(), test.height());
  for (int r = 0; r < test.height(); ++r)
    for (int c = 0; c < test.width(); ++c)
      out.pixels(r, c) = static_cast<float>(
          std::sqrt(squared_pu21_difference(test.pixels(r, c), reference.pixels(r, c))));
  return out;
}

double srgb_psnr(const RgbImage& test, const RgbImage& reference, double white_cd_m2,
                 const cv::Mat1b* mask) {
  if (!(white_cd_m2 > 0) || !std::isfinite(white_cd_m2))
    throw ArgumentError(fmt::format("white of {} cd/m^2 is not positive", white_cd_m2),
                        "give the luminance of code 255");
  require_comparable(test, reference, mask);
  const cv::Mat3b a = to_srgb8(test, white_cd_m2), b = to_srgb8(reference, white_cd_m2);
  return psnr_db(a.size(), mask, 255, [&](int r, int c) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
      const double d = double(a(r, c)[k]) - b(r, c)[k];
      sum += d * d;
    }
    return sum / 3;
  });
}

}  // namespace wheatstone
