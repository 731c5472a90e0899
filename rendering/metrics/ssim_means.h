#pragma once
// SSIM of two planes that come row by row. Internal to rendering/metrics.

#include <functional>
#include <opencv2/core.hpp>

namespace wheatstone::detail {

/// Writes one row of test and reference; false if it came from light that is not valid. Called from
/// several threads at once, and for some rows more than once.
using PairedRows = std::function<bool(int row, float* test, float* reference)>;

struct SsimMeans {
  double ssim = 0, contrast_structure = 0;
  bool valid = true;  // false if any row was not; the means are then meaningless
};

/// Mean SSIM and contrast-structure factor over `size` pixels, weighted if `weights` is given (not
/// all 0). map, if given, has that size already.
SsimMeans ssim_means(cv::Size size, const PairedRows&, const cv::Mat1f* weights = nullptr,
                     cv::Mat1f* map = nullptr);

}  // namespace wheatstone::detail
