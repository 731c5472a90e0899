#pragma once
// Planes for tests of filters, and the definition that those filters are faster forms of.

#include <cmath>
#include <opencv2/core.hpp>

#include "core/random.h"

namespace wheatstone {

/// Uniform on (0, 1), some samples a thousand times brighter.
inline cv::Mat1d random_plane(cv::Size size, std::uint64_t seed = 1) {
  RandomStream random(seed, 0);
  cv::Mat1d plane(size);
  for (double& v : plane) v = random.uniform() * (random.next() % 16 == 0 ? 1000 : 1);
  return plane;
}

inline double largest_difference(const cv::Mat1d& a, const cv::Mat1d& b) {
  return cv::norm(a, b, cv::NORM_INF);
}

/// `plane` continued to twice its size to the right and down (`continued(i, n)` names the sample at
/// position i of n, -1 for 0), its spectrum multiplied by gain(y, x) (cycles per pixel) and
/// cropped.
template <class Continued, class Gain>
cv::Mat1d filter_by_fourier(const cv::Mat1d& plane, Continued continued, Gain gain) {
  cv::Mat1d twice(2 * plane.rows, 2 * plane.cols);
  for (int r = 0; r < twice.rows; ++r)
    for (int c = 0; c < twice.cols; ++c) {
      const int y = continued(r, plane.rows), x = continued(c, plane.cols);
      twice(r, c) = y < 0 || x < 0 ? 0 : plane(y, x);
    }
  const auto frequency = [](int k, int n) { return (2 * k > n ? k - n : k) / double(n); };
  cv::Mat2d spectrum;
  cv::dft(twice, spectrum, cv::DFT_COMPLEX_OUTPUT);
  for (int r = 0; r < twice.rows; ++r)
    for (int c = 0; c < twice.cols; ++c)
      spectrum(r, c) *= gain(frequency(r, twice.rows), frequency(c, twice.cols));
  cv::dft(spectrum, twice, cv::DFT_INVERSE | cv::DFT_SCALE | cv::DFT_REAL_OUTPUT);
  return twice(cv::Rect({0, 0}, plane.size())).clone();
}

}  // namespace wheatstone
