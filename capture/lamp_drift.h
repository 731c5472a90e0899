#pragma once
// Views of one light field on one scale, although the lamps drift while they are taken.

#include <opencv2/core.hpp>

#include "capture/merge.h"

namespace wheatstone {

/// Mean of a patch that every view shows, over all its colours alike.
struct PatchReading {
  double mean_dn_s = 0, sigma_dn_s = 0;  // sigma: of the mean, 0 without noise parameters
};

/// Reads the monitor patch of one merged view. Saturated and underexposed pixels are refused: a
/// patch must be well exposed in all views.
/// Errors: ArgumentError for a patch that is empty, outside of the view, or not well exposed.
PatchReading read_monitor_patch(const MergedMosaic&, const cv::Rect& patch);

/// By what a view must be multiplied to have the lamps of the first one.
struct LampCorrection {
  double factor = 1, sigma = 0;
};
/// Errors: ArgumentError for a reading that is not positive, or a view that deviates from the first
/// by more than `largest_drift` (a hand before the patch is no drift).
LampCorrection lamp_correction(const PatchReading& first, const PatchReading& view,
                               double largest_drift = 0.2);

}  // namespace wheatstone
