#include "rendering/metrics/hdrvdp3/resize.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <vector>

namespace wheatstone {
namespace {

double keys_kernel(double x) {
  x = std::abs(x);
  if (x <= 1) return (1.5 * x - 2.5) * x * x + 1;
  if (x <= 2) return ((-0.5 * x + 2.5) * x - 4) * x + 2;
  return 0;
}

struct Tap {
  int source;
  double weight;
};

/// The samples and weights that make each of n_out samples out of n_in.
std::vector<std::vector<Tap>> make_taps(int n_in, int n_out) {
  const double scale = static_cast<double>(n_out) / n_in;
  const double widening = std::max(1.0, 1 / scale);
  std::vector<std::vector<Tap>> all;
  for (int i = 0; i < n_out; ++i) {
    const double centre = (i + 0.5) / scale - 0.5;
    std::vector<Tap> taps;
    double sum = 0;
    const int last = static_cast<int>(std::floor(centre + 2 * widening));
    for (int k = static_cast<int>(std::ceil(centre - 2 * widening)); k <= last; ++k) {
      const double weight = keys_kernel((k - centre) / widening);
      if (weight == 0) continue;
      const int period = 2 * n_in, wrapped = (k % period + period) % period;
      taps.push_back({wrapped < n_in ? wrapped : period - 1 - wrapped, weight});
      sum += weight;
    }
    for (Tap& t : taps) t.weight /= sum;
    all.push_back(taps);
  }
  return all;
}

}  // namespace

cv::Mat1d resize_bicubic(const cv::Mat1d& in, cv::Size size) {
  if (in.size() == size) return in;
  const auto row_taps = make_taps(in.rows, size.height),
             column_taps = make_taps(in.cols, size.width);
  cv::Mat1d out(size);
  tbb::parallel_for(0, size.height, [&](int r) {
    std::vector<double> line(in.cols, 0.0);
    for (const Tap& t : row_taps[r]) {
      const double* from = in[t.source];
      for (int c = 0; c < in.cols; ++c) line[c] += t.weight * from[c];
    }
    for (int c = 0; c < size.width; ++c) {
      double sum = 0;
      for (const Tap& t : column_taps[c]) sum += t.weight * line[t.source];
      out(r, c) = sum;
    }
  });
  return out;
}

}  // namespace wheatstone
