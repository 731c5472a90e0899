#pragma once

#include <tbb/parallel_for.h>

#include <opencv2/core.hpp>

namespace wheatstone {

/// plane(r, c) = pixel(r, c) for every pixel, rows in parallel. `pixel` may read that pixel's old
/// value.
template <class Pixel>
void fill_plane(cv::Mat1d& plane, const Pixel& pixel) {
  tbb::parallel_for(0, plane.rows, [&](int r) {
    double* row = plane[r];
    for (int c = 0; c < plane.cols; ++c) row[c] = pixel(r, c);
  });
}

template <class Pixel>
cv::Mat1d make_plane(cv::Size size, const Pixel& pixel) {
  cv::Mat1d plane(size);
  fill_plane(plane, pixel);
  return plane;
}

}  // namespace wheatstone
