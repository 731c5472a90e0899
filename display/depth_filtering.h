#pragma once
// Linear depth filtering: how much of a point's light each focal plane shows (Akeley et al. 2004;
// reference multifocal.md). Weights multiply linear light before the dual-modulation split.

#include <span>
#include <vector>

#include "core/image.h"
#include "core/units.h"

namespace wheatstone {

/// Weight of each plane for a point at vergence `point`; the weights sum to 1. Linear in dioptres
/// between the two planes around the point, saturated in front of the first and behind the last.
/// Pre: at least one plane, strictly descending (near to far), all finite; else ArgumentError.
/// Take vergences from exact calibrated distances: rounded dioptres move weights by 0.4 %.
std::vector<double> plane_weights(std::span<const Vergence> planes_near_to_far, Vergence point);

struct PlanePair {
  RgbImage near_cd_m2, far_cd_m2;
};

/// near = weight_near * light, far = (1 - weight_near) * light, same size as the input. Only for
/// content whose planes share one projection; a rendered scene is drawn once per plane instead.
/// Errors: ArgumentError: sizes differ, invalid radiance, a weight outside [0, 1] or NaN.
PlanePair split_by_depth(const RgbImage& light_cd_m2, const ScalarImage& weight_near);

/// Light times its weight, per pixel or constant. Same errors as split_by_depth.
RgbImage weighted(const RgbImage& light_cd_m2, const ScalarImage& weight);
RgbImage weighted(const RgbImage& light_cd_m2, double weight);

/// Shift between the images of two planes, in radian, when the eye moves sideways by `eye_shift`:
/// eye_shift (1/near - 1/far).
double lateral_misalignment_rad(Length eye_shift, Length near_plane, Length far_plane);

/// How much the near plane grows relative to the far one when the eye moves towards both by
/// `eye_shift`: near/(near - e) / (far/(far - e)) - 1. Pre: eye_shift < both distances.
double axial_relative_magnification(Length eye_shift, Length near_plane, Length far_plane);

}  // namespace wheatstone
