#pragma once
// Inside of merge.cpp: the estimators, one row of 2x2 cells at a time.

#include <array>
#include <cstdint>
#include <vector>

#include "capture/merge.h"

namespace wheatstone {

/// Merges cells with whatever frames are usable there. Most neighbours agree on that, so blocks of
/// cells are tried first and halved where they do not.
class CellMerger {
 public:
  /// Checked frames, the shortest first; they and the options must outlive the merger.
  CellMerger(const std::vector<const RawExposure*>& frames, const MergeOptions&);

  /// Writes rows 2 * cell_row and, if there is one, 2 * cell_row + 1 of `out`.
  void merge_row_of_cells(int cell_row, MergedMosaic& out);

 private:
  struct Frame {
    const cv::Mat1w* dn;
    float time_s;
    float scale;       // 1 / (g A)
    float shot_s;      // t / A: adds k phi t / A to the variance of the sum
    float electronic;  // (s_read^2 + s_adc^2 / g^2) / A^2: adds k^2 times it
    double exposure_s, gain, area;
  };
  static constexpr int kBlock_px = 128;
  using Row = std::array<float, kBlock_px>;
  enum class Usable { kNone, kSome, kAll };

  Usable usable_in(const Frame&, const cv::Rect& cells) const;
  void merge(const cv::Rect& cells, MergedMosaic& out);
  void merge_poisson(const cv::Rect& cells, std::uint8_t flags, MergedMosaic& out) const;
  void merge_full_noise(const cv::Rect& cells, MergedMosaic& out) const;

  const MergeOptions& options_;
  BayerPattern pattern_;
  std::array<Row, 2> black_dn_, k_;  // of even and odd rows, repeated along a block
  std::vector<Frame> frames_;
  std::vector<const Frame*> used_;  // in the cells in work
};

}  // namespace wheatstone
