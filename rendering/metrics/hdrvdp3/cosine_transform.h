#pragma once
// The discrete cosine transform (DCT-II) of whole images, of any size, odd ones included
// (OpenCV's own takes even sizes only). Filtering an image that is continued by its mirror image,
// edge sample repeated, with a real even transfer function is a product in this transform.
// Source: Makhoul, "A fast cosine transform in one and two dimensions", IEEE TASSP 28(1), 1980.

#include <opencv2/core.hpp>

namespace wheatstone {

/// X(l, k) = sum over m, n of x(m, n) cos(pi l (2m + 1) / 2H) cos(pi k (2n + 1) / 2W).
/// Index k belongs to k / 2W cycles per pixel. Same bytes for every number of threads.
void cosine_transform(cv::Mat1d& image_to_spectrum);
/// Its exact inverse.
void inverse_cosine_transform(cv::Mat1d& spectrum_to_image);

}  // namespace wheatstone
