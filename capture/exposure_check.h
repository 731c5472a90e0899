#pragma once
// Do the frames of a stack show what their times and gains say?

#include <span>
#include <string>
#include <vector>

#include "capture/merge.h"

namespace wheatstone {

/// Two neighbouring exposures of a stack: how much more the longer one collects.
struct ExposureRatio {
  std::size_t shorter = 0, longer = 0;  // indices in the stack, by time x gain x area
  double stated = 1;                    // by time x gain x area
  double measured = 1;                  // by the codes above black
};
/// The neighbours whose codes say another ratio than their times and gains, by more than
/// `tolerance`: swapped or wrong times, gains or black levels, or one frame twice. Measured are
/// sums over photosites that are unsaturated in both and at least a hundredth of the range above
/// black in the first; pairs with fewer than 100 of them are not judged. Errors: as
/// check_exposures().
std::vector<ExposureRatio> contradicting_exposures(std::span<const RawExposure>,
                                                   const MergeOptions&, double tolerance = 0.12);

/// Codes of a frame that end below the stated saturation, as those of a sensor do that saturates
/// earlier.
struct PileUp {
  int highest_dn = 0;
  double share = 0;  // of the photosites that have this code; 0: there is no pile-up
};
/// A pile-up: at least 0.1 % of the photosites have the frame's highest code, that code is below
/// the saturation, and each of the 32 codes before it is on average at most a tenth as frequent.
/// Light alone, which fades out towards its highest values, does not do that.
PileUp pile_up(const MosaicImage&, int saturation_dn);

/// Both checks as warnings for people, empty if nothing is wrong. `names`: one per exposure, such
/// as its file. Errors: as check_exposures(); ArgumentError unless there are as many names.
std::vector<std::string> exposure_warnings(std::span<const RawExposure>, const MergeOptions&,
                                           std::span<const std::string> names);

}  // namespace wheatstone
