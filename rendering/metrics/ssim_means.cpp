#include "rendering/metrics/ssim_means.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <vector>

#include "rendering/metrics/row_kernels.h"

namespace wheatstone::detail {
namespace {

constexpr int kRadius = SsimWindow::kRadius, kTaps = SsimWindow::kTaps;
// A tile's eleven rows of sums and differences fill half of a usual first-level cache.
constexpr int kTileWidth = 256, kTileColumns = kTileWidth - 2 * kRadius, kTileRows = 128;

using Row = std::array<float, kTileWidth>;

struct TileSums {
  double ssim = 0, contrast_structure = 0;
  bool valid = true;
};

/// One tile from the rows to its sums, with everything between in the cache.
class Tile {
 public:
  Tile(cv::Size size, cv::Rect area, const PairedRows& rows, const cv::Mat1f* weights,
       cv::Mat1f* map)
      : size_(size), area_(area), rows_(rows), weights_(weights), map_(map) {}

  TileSums run() {
    for (int row = area_.y - kRadius; row < area_.y + kRadius; ++row) load(row);
    for (int row = area_.y; row < area_.y + area_.height; ++row) {
      load(row + kRadius);
      score(row);
    }
    TileSums out{0, 0, valid_};
    for (int i = 0; i < area_.width; ++i) {
      out.ssim += ssim_sums_[i];
      out.contrast_structure += contrast_structure_sums_[i];
    }
    return out;
  }

 private:
  int slot(int row) const { return (row - area_.y + kTaps) % kTaps; }

  /// Sum and difference of a row, with the picture's border repeated around it.
  void load(int row) {
    const int first = area_.x - kRadius, last = area_.x + area_.width + kRadius;
    const int begin = std::max(first, 0), end = std::min(last, size_.width);
    alignas(64) Row test, reference;
    const int left = begin - first, count = end - begin, width = last - first;
    valid_ &= rows_(std::clamp(row, 0, size_.height - 1), begin, count, test.data() + left,
                    reference.data() + left);
    for (Row* values : {&test, &reference}) {
      std::fill_n(values->begin(), left, (*values)[left]);
      std::fill(values->begin() + left + count, values->begin() + width,
                (*values)[left + count - 1]);
    }
    Row &s = sums_[slot(row)], &d = differences_[slot(row)];
    for (int i = 0; i < width; ++i) {
      s[i] = test[i] + reference[i];
      d[i] = test[i] - reference[i];
    }
  }

  void score(int row) {
    std::array<const float*, kTaps> s{}, d{};
    for (int k = 0; k < kTaps; ++k) {
      s[k] = sums_[slot(row + k - kRadius)].data();
      d[k] = differences_[slot(row + k - kRadius)].data();
    }
    alignas(64) Row mean_s, variance_s, mean_d, square_d, ssim, contrast_structure;
    const MomentRows moments{mean_s.data(), variance_s.data(), mean_d.data(), square_d.data()};
    window_columns(window_, s.data(), d.data(), area_.width + 2 * kRadius, moments, simd_);
    window_row(window_, moments, area_.width, ssim.data(), contrast_structure.data(), simd_);
    const float* weights = weights_ ? (*weights_)[row] + area_.x : nullptr;
    accumulate_row(ssim.data(), weights, area_.width, ssim_sums_.data(), simd_);
    accumulate_row(contrast_structure.data(), weights, area_.width, contrast_structure_sums_.data(),
                   simd_);
    if (map_) std::copy_n(ssim.begin(), area_.width, (*map_)[row] + area_.x);
  }

  const Simd simd_ = best_simd();
  const SsimWindow window_;
  const cv::Size size_;
  const cv::Rect area_;
  const PairedRows& rows_;
  const cv::Mat1f* weights_;
  cv::Mat1f* map_;
  alignas(64) std::array<Row, kTaps> sums_, differences_;  // a ring: row r is at slot(r)
  std::array<double, kTileColumns> ssim_sums_{}, contrast_structure_sums_{};
  bool valid_ = true;
};

}  // namespace

SsimMeans ssim_means(cv::Size size, const PairedRows& rows, const cv::Mat1f* weights,
                     cv::Mat1f* map) {
  std::vector<cv::Rect> areas;
  for (int y = 0; y < size.height; y += kTileRows)
    for (int x = 0; x < size.width; x += kTileColumns)
      areas.emplace_back(x, y, std::min(kTileColumns, size.width - x),
                         std::min(kTileRows, size.height - y));
  std::vector<TileSums> sums(areas.size());
  tbb::parallel_for(std::size_t{0}, areas.size(), [&](std::size_t i) {
    sums[i] = Tile(size, areas[i], rows, weights, map).run();
  });
  SsimMeans out;
  for (const TileSums& s : sums) {  // in the tiles' order, whichever thread did them
    out.ssim += s.ssim;
    out.contrast_structure += s.contrast_structure;
    out.valid &= s.valid;
  }
  const double total = weights ? cv::sum(*weights)[0] : static_cast<double>(size.area());
  out.ssim /= total;
  out.contrast_structure /= total;
  return out;
}

}  // namespace wheatstone::detail
