#pragma once
// Numbers as colours, for people: luminance pictures and difference pictures with a legend below.

#include <string>

#include "core/image.h"

namespace wheatstone {

/// Luminance on a logarithmic scale from min to max (darker and brighter light takes the colour of
/// the end), dark blue over green to yellow. The legend has a tick every whole number of stops,
/// 0 stops being 1 cd/m^2, with the cd/m^2 above it. The picture's width is kept, the legend adds
/// rows. R, G, B.
/// Colours: viridis, whose lightness grows evenly (Smith and van der Walt 2015), as OpenCV has it.
/// Errors: ArgumentError for an empty picture, unless 0 < min < max.
cv::Mat3b false_colour_luminance(const RgbImage& light_cd_m2, double min_cd_m2, double max_cd_m2);

/// 0 (black) over violet and orange to `top` and above (pale yellow), linear; `quantity` stands on
/// the legend, such as "PU21 units". Colours: inferno, by the same authors.
/// Errors: ArgumentError for an empty picture, unless top is positive and finite.
cv::Mat3b false_colour_difference(const ScalarImage&, double top, const std::string& quantity);

}  // namespace wheatstone
