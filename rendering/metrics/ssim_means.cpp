#include "rendering/metrics/ssim_means.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include "rendering/metrics/row_kernels.h"

namespace wheatstone::detail {
namespace {

constexpr int kRadius = SsimWindow::kRadius, kTaps = SsimWindow::kTaps;
// Pictures are read in whole rows, which memory delivers fastest, and windowed in tiles of a block
// of rows: a block's sums and differences fit the second-level cache (313 kB at 2160 columns), a
// tile's the first.
constexpr int kStripRows = 240, kBlockRows = 8, kRingRows = kBlockRows + 2 * kRadius;
constexpr int kTileWidth = 256, kTileColumns = kTileWidth - 2 * kRadius;

using TileRow = std::array<float, kTileWidth>;

/// What a thread works in. Kept from one call to the next: pages fresh from the system would cost
/// as much time as the windows themselves.
struct Workspace {
  cv::Mat1f pair;                                          // a row of test, a row of reference
  cv::Mat1f sums, differences;                             // rings of rows
  std::vector<double> ssim_sums, contrast_structure_sums;  // of each column
};

/// A strip of rows, scored by one thread.
class Strip {
 public:
  Strip(cv::Size size, const PairedRows& rows, const cv::Mat1f* weights, cv::Mat1f* map)
      : size_(size), rows_(rows), weights_(weights), map_(map), work_(workspace()) {
    work_.pair.create(2, padded_width());
    work_.sums.create(kRingRows, padded_width());
    work_.differences.create(kRingRows, padded_width());
    work_.ssim_sums.assign(size.width, 0.0);
    work_.contrast_structure_sums.assign(size.width, 0.0);
  }

  /// Sums, not means, over rows begin..end-1.
  SsimMeans run(int begin, int end) {
    int loaded = begin - kRadius;
    for (int block = begin; block < end; block += kBlockRows) {
      const int block_end = std::min(block + kBlockRows, end);
      for (; loaded < block_end + kRadius; ++loaded) load(loaded);
      for (int column = 0; column < size_.width; column += kTileColumns)
        for (int row = block; row < block_end; ++row)
          score(row, column, std::min(kTileColumns, size_.width - column));
    }
    return {std::accumulate(work_.ssim_sums.begin(), work_.ssim_sums.end(), 0.0),
            std::accumulate(work_.contrast_structure_sums.begin(),
                            work_.contrast_structure_sums.end(), 0.0),
            valid_};
  }

 private:
  static Workspace& workspace() {
    thread_local Workspace work;
    return work;
  }
  /// With the repeated borders, and a multiple of 64 bytes, as vectors like it.
  int padded_width() const { return (size_.width + 2 * kRadius + 15) / 16 * 16; }
  static int ring_row(int row) { return (row + kRadius) % kRingRows; }

  /// Sum and difference of a row, with the picture's border repeated around it.
  void load(int row) {
    valid_ &= rows_(std::clamp(row, 0, size_.height - 1), work_.pair[0] + kRadius,
                    work_.pair[1] + kRadius);
    for (float* values : {work_.pair[0], work_.pair[1]}) {
      float* end = values + kRadius + size_.width;
      std::fill_n(values, kRadius, values[kRadius]);
      std::fill_n(end, kRadius, end[-1]);
    }
    sum_and_difference_row(work_.pair[0], work_.pair[1], size_.width + 2 * kRadius,
                           work_.sums[ring_row(row)], work_.differences[ring_row(row)], simd_);
  }

  void score(int row, int column, int count) {
    std::array<const float*, kTaps> s{}, d{};
    for (int k = 0; k < kTaps; ++k) {
      s[k] = work_.sums[ring_row(row + k - kRadius)] + column;
      d[k] = work_.differences[ring_row(row + k - kRadius)] + column;
    }
    alignas(64) TileRow mean_s, variance_s, mean_d, square_d, ssim, contrast_structure;
    const MomentRows moments{mean_s.data(), variance_s.data(), mean_d.data(), square_d.data()};
    window_columns(window_, s.data(), d.data(), count + 2 * kRadius, moments, simd_);
    window_row(window_, moments, count, ssim.data(), contrast_structure.data(), simd_);
    const float* weights = weights_ ? (*weights_)[row] + column : nullptr;
    accumulate_row(ssim.data(), weights, count, work_.ssim_sums.data() + column, simd_);
    accumulate_row(contrast_structure.data(), weights, count,
                   work_.contrast_structure_sums.data() + column, simd_);
    if (map_) std::copy_n(ssim.begin(), count, (*map_)[row] + column);
  }

  const Simd simd_ = best_simd();
  const SsimWindow window_;
  const cv::Size size_;
  const PairedRows& rows_;
  const cv::Mat1f* weights_;
  cv::Mat1f* map_;
  Workspace& work_;
  bool valid_ = true;
};

}  // namespace

SsimMeans ssim_means(cv::Size size, const PairedRows& rows, const cv::Mat1f* weights,
                     cv::Mat1f* map) {
  std::vector<SsimMeans> sums((size.height + kStripRows - 1) / kStripRows);
  tbb::parallel_for(std::size_t{0}, sums.size(), [&](std::size_t i) {
    const int begin = static_cast<int>(i) * kStripRows;
    sums[i] = Strip(size, rows, weights, map).run(begin, std::min(begin + kStripRows, size.height));
  });
  SsimMeans out;
  for (const SsimMeans& s : sums) {  // in the strips' order, whichever thread did them
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
