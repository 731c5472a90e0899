#pragma once
// Inside of merge.cpp: the estimators, one row of 2x2 cells at a time.

#include <array>
#include <cstdint>
#include <vector>

#include "capture/merge.h"

namespace wheatstone {

/// What the sums over frames need to know of one frame, repeated for eight neighbouring pixels:
/// the upper or lower row of four cells.
struct FrameTerms {
  using Lanes = float __attribute__((vector_size(32)));
  Lanes scale;       // 1 / (g A)
  Lanes time_s;      // t
  Lanes shot_s;      // t / A: adds k phi t / A to the variance of the sum
  Lanes electronic;  // (s_read^2 + s_adc^2 / g^2) / A^2: adds k^2 times it
};

/// Merges rows of cells: each pixel over the frames in which its whole cell is usable.
class CellMerger {
 public:
  /// Checked frames, the shortest first; they and the options must outlive the merger.
  CellMerger(const std::vector<const RawExposure*>& frames, const MergeOptions&);

  /// Writes rows 2 * cell_row and, if there is one, 2 * cell_row + 1 of `out`.
  void merge_row_of_cells(int cell_row, MergedMosaic& out);

 private:
  void merge_poisson(int top, int bottom, MergedMosaic& out);
  void merge_full_noise(int top, int bottom, MergedMosaic& out);

  const MergeOptions& options_;
  BayerPattern pattern_;
  std::vector<const RawExposure*> frames_;
  std::vector<FrameTerms> terms_;
  // Of one row of cells: where its upper and lower row begin in each frame, and its last columns
  // of each frame, filled up to a whole vector.
  std::vector<const std::uint16_t*> rows_;
  std::vector<std::uint16_t> tail_;
};

}  // namespace wheatstone
