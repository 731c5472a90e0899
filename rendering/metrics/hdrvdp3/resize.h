#pragma once
// Bicubic resizing as the metric defines it (OpenCV's has another kernel and no antialiasing).

#include <opencv2/core.hpp>

namespace wheatstone {

/// Catmull-Rom kernel (a = -0.5), widened to the pixel of the smaller image when shrinking. Image
/// corners stay corners (pixel x of n goes to (x + 0.5) n' / n - 0.5); beyond its borders the image
/// goes on as its mirror image, edge sample repeated; weights sum to 1. May overshoot.
/// The size itself gives the same pixels, not copied. Same bytes for every number of threads.
/// Source: Keys, IEEE TASSP 29(6), 1981; reference metrics.md, section 4, last paragraph.
cv::Mat1d resize_bicubic(const cv::Mat1d&, cv::Size);

}  // namespace wheatstone
