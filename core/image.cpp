#include "core/image.h"

#include <cmath>

#include "core/error.h"

namespace wheatstone {

namespace {
constexpr const char* kPatternNames[] = {"RGGB", "BGGR", "GRBG", "GBRG"};
}

std::string to_string(BayerPattern p) {
  return kPatternNames[static_cast<int>(p)];
}

BayerPattern bayer_pattern_from_string(const std::string& text) {
  for (int i = 0; i < 4; ++i)
    if (text == kPatternNames[i]) return static_cast<BayerPattern>(i);
  throw ArgumentError("'" + text + "' is no Bayer pattern", "use RGGB, BGGR, GRBG or GBRG");
}

int bayer_colour(BayerPattern p, int row, int column) {
  const char letter = kPatternNames[static_cast<int>(p)][2 * (row & 1) + (column & 1)];
  return letter == 'R' ? 0 : letter == 'G' ? 1 : 2;
}

ScalarImage luminance_cd_m2(const RgbImage& image) {
  ScalarImage out(image.width(), image.height());
  for (int r = 0; r < image.height(); ++r)
    for (int c = 0; c < image.width(); ++c) {
      const cv::Vec3f& p = image.pixels(r, c);
      out.pixels(r, c) = static_cast<float>(
          kLuminanceWeights[0] * p[0] + kLuminanceWeights[1] * p[1] + kLuminanceWeights[2] * p[2]);
    }
  return out;
}

void require_valid_radiance(const RgbImage& image, const std::string& what) {
  std::int64_t nan = 0, infinite = 0, negative = 0;
  int first_row = -1, first_column = -1;
  for (int r = 0; r < image.height(); ++r)
    for (int c = 0; c < image.width(); ++c)
      for (int k = 0; k < 3; ++k) {
        const float v = image.pixels(r, c)[k];
        if (std::isfinite(v) && v >= 0) continue;
        (std::isnan(v) ? nan : std::isinf(v) ? infinite : negative) += 1;
        if (first_row < 0) first_row = r, first_column = c;
      }
  if (first_row < 0) return;
  std::ostringstream out;
  out << what << " holds impossible radiance: " << nan << " NaN, " << infinite << " infinite, "
      << negative << " negative samples, first at column " << first_column << ", row " << first_row;
  throw ArgumentError(out.str(), "repair or leave out this image");
}

}  // namespace wheatstone
