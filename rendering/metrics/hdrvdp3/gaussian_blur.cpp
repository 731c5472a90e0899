#include "rendering/metrics/hdrvdp3/gaussian_blur.h"

#include <tbb/parallel_for.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr double kWideSigmaPx = 4.3;

/// Weights from the centre outwards; the mirrored half has the same.
std::vector<double> half_kernel(double sigma_px) {
  int radius = static_cast<int>(std::ceil(6 * sigma_px));
  if (sigma_px < kWideSigmaPx) radius = static_cast<int>(std::lround(6 * sigma_px)) / 2;
  std::vector<double> weights;
  for (int k = 0; k <= radius; ++k)
    weights.push_back(std::exp(-0.5 * k * k / (sigma_px * sigma_px)));
  const double sum = 2 * std::accumulate(weights.begin(), weights.end(), 0.0) - weights[0];
  for (double& w : weights) w /= sum;
  return weights;
}

constexpr int kNothing = -1;

/// Which of n samples stands at each of the positions -radius .. n - 1 + radius.
std::vector<int> continued(int n, int radius, double sigma_px, BlurBorder border) {
  std::vector<int> source;
  for (int i = -radius; i < n + radius; ++i) {
    int at = i;
    if (sigma_px >= kWideSigmaPx) at = (i % (2 * n) + 2 * n) % (2 * n);
    const bool inside = at >= 0 && at < n;
    source.push_back(!inside && border == BlurBorder::kZero ? kNothing : std::clamp(at, 0, n - 1));
  }
  return source;
}

/// out[i] = sum over k of weight |k| times in[i + k spacing], for 0 <= i < count.
void correlate(const double* in, int spacing, const std::vector<double>& half, double* out,
               int count) {
  using Block = Eigen::Array<double, 16, 1>;  // sums that stay in registers
  int i = 0;
  for (; i + Block::SizeAtCompileTime <= count; i += Block::SizeAtCompileTime) {
    const double* const centre = in + i;
    Block sum = half[0] * Block::Map(centre);
    for (std::size_t k = 1; k < half.size(); ++k) {
      const std::ptrdiff_t offset = static_cast<std::ptrdiff_t>(k) * spacing;
      sum += half[k] * (Block::Map(centre - offset) + Block::Map(centre + offset));
    }
    Block::Map(out + i) = sum;
  }
  for (; i < count; ++i) {
    out[i] = half[0] * in[i];
    for (std::size_t k = 1; k < half.size(); ++k) {
      const std::ptrdiff_t offset = static_cast<std::ptrdiff_t>(k) * spacing;
      out[i] += half[k] * (in[i - offset] + in[i + offset]);
    }
  }
}

}  // namespace

void gaussian_blur(cv::Mat1d& image, double sigma_px, BlurBorder border) {
  WHEATSTONE_CHECK(sigma_px, >, 0);
  const std::vector<double> half = half_kernel(sigma_px);
  const int radius = static_cast<int>(half.size()) - 1;

  const std::vector<int> columns = continued(image.cols, radius, sigma_px, border);
  tbb::parallel_for(0, image.rows, [&](int r) {
    std::vector<double> line;
    for (const int c : columns) line.push_back(c == kNothing ? 0 : image(r, c));
    correlate(line.data() + radius, 1, half, image[r], image.cols);
  });

  // Columns in narrow tiles, whose rows in reach of the kernel stay in the cache.
  constexpr int kTileColumns = 32;
  const std::vector<int> rows = continued(image.rows, radius, sigma_px, border);
  tbb::parallel_for(0, (image.cols + kTileColumns - 1) / kTileColumns, [&](int tile) {
    const int first = tile * kTileColumns, width = std::min(kTileColumns, image.cols - first);
    std::vector<double> lines(rows.size() * width), blurred(std::size_t(image.rows) * width);
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (rows[i] != kNothing)
        std::copy_n(image[rows[i]] + first, width, lines.begin() + i * width);
    correlate(lines.data() + std::ptrdiff_t{radius} * width, width, half, blurred.data(),
              image.rows * width);
    for (int r = 0; r < image.rows; ++r)
      std::copy_n(blurred.begin() + std::size_t(r) * width, width, image[r] + first);
  });
}

}  // namespace wheatstone
