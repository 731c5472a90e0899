#pragma once
// What every metric asks of its two pictures before it computes. Internal to rendering/metrics.

#include "core/image.h"

namespace wheatstone::detail {

/// Errors: ArgumentError unless both pictures have the same, positive size, and the mask (if any)
/// has that size too and selects a pixel.
void require_same_size(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask);

/// Errors: ArgumentError naming the picture if it is black all over (which no camera or display
/// delivers, but a wrong file does).
void require_not_black(const RgbImage& test, const RgbImage& reference);

/// Errors: ArgumentError naming the picture if light is NaN, infinite or negative.
void require_valid_light(const RgbImage& test, const RgbImage& reference);

}  // namespace wheatstone::detail
