#pragma once
// Exposure stacks of encoded pictures: film scans and camera JPEGs, whose codes are no linear
// light.

#include <array>
#include <opencv2/core.hpp>
#include <vector>

namespace wheatstone {

/// Natural logarithm of the exposure (light x time) that gives each 8-bit code; 0 at code 128,
/// because only ratios of exposures show in a stack.
using ResponseCurve = std::array<double, 256>;

/// One channel of a registered stack.
struct EncodedStack {
  std::vector<cv::Mat1b> frames;
  std::vector<double> exposure_s;
};

/// The smooth curve that explains a grid of pixels best, by weighted least squares; codes near the
/// middle count most, 0 and 255 not at all.
/// Errors: ArgumentError for fewer than two frames, sizes that disagree, times that are not
/// positive or all equal, and a stack with too few well-exposed pixels.
/// Source: P. Debevec, J. Malik, "Recovering High Dynamic Range Radiance Maps from Photographs",
///         SIGGRAPH 1997, eq. 3 and 4.
ResponseCurve fit_response_curve(const EncodedStack&, double smoothness = 30);

/// Relative light of one channel: the weighted mean logarithm over frames (eq. 6). Pixels that no
/// frame shows between codes 1 and 254 take the end of the curve in the shortest (all white) or the
/// longest frame (all black). Errors: as fit_response_curve().
cv::Mat1f merge_encoded(const EncodedStack&, const ResponseCurve&);

}  // namespace wheatstone
