#include "rendering/metrics/comparable.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"

namespace wheatstone::detail {

void require_same_size(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask) {
  if (test.empty() || test.pixels.size() != reference.pixels.size())
    throw ArgumentError(
        fmt::format("the test image has {}x{} pixels, the reference {}x{}", test.width(),
                    test.height(), reference.width(), reference.height()),
        "compare pictures of the same size");
  if (!mask) return;
  if (mask->size() != test.pixels.size())
    throw ArgumentError(fmt::format("the mask has {}x{} pixels, the images {}x{}", mask->cols,
                                    mask->rows, test.width(), test.height()),
                        "give a mask of the images' size");
  if (cv::countNonZero(*mask) == 0)
    throw ArgumentError("the mask selects no pixel", "give a mask that selects some");
}

void require_not_black(const RgbImage& test, const RgbImage& reference) {
  for (const RgbImage* image : {&test, &reference})
    if (std::all_of(image->pixels.begin(), image->pixels.end(),
                    [](const cv::Vec3f& p) { return p[0] == 0 && p[1] == 0 && p[2] == 0; }))
      throw ArgumentError(
          fmt::format("the {} image is black all over", image == &test ? "test" : "reference"),
          "check that it is the right file");
}

void require_valid_light(const RgbImage& test, const RgbImage& reference) {
  require_valid_radiance(test, "the test image");
  require_valid_radiance(reference, "the reference image");
}

}  // namespace wheatstone::detail
