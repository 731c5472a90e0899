#pragma once
// The exposure times a camera really kept, from the frames themselves (hdr_merge.md, sec. 3).

#include <span>
#include <string>
#include <vector>

#include "capture/merge.h"

namespace wheatstone {

/// Which frames are compared at a pixel: each with the next longer one, or (maximum-weight
/// spanning tree) each with the longest one that is neither saturated nor in the noise there.
enum class ExposurePairing { kPairwise, kMst };
ExposurePairing exposure_pairing_from_string(const std::string&);  // "pairwise", "mst"

struct ExposureTimes {
  std::vector<double> exposure_s;  // in the order of the frames
  std::vector<bool> estimated;     // false: the nominal time is kept, and `note` says why
  std::string note;                // empty when every frame was estimated
  int equations = 0;
};

/// Least squares of log exposure ratios over green pixels, of each of 16 x 16 tiles the brightest
/// that are well exposed in neighbouring frames. The longest usable frame keeps its nominal time,
/// since only ratios show. `weighted` weighs each ratio by its variance: photon noise, or with
/// options.noise the whole model. Frames with more than 95 % of saturated or noisy pixels are not
/// estimated, nor those that would deviate by more than 200 % from nominal; with fewer than three
/// usable frames none is. Errors: as merge_exposures(); also ArgumentError for frames smaller than
/// one tile (16 x 16 px). Source: P. Hanji, F. Zhong, R. K. Mantiuk, "Noise-Aware Merging of High
/// Dynamic Range Image
///         Stacks without Camera Calibration", ECCV workshops 2020; Hanji and Mantiuk, IEEE TCI
///         2023.
ExposureTimes estimate_exposure_times(std::span<const RawExposure>, const MergeOptions&,
                                      ExposurePairing, bool weighted);

}  // namespace wheatstone
