#pragma once
// Where to put the focal plane: the depth at which neighbouring photographs agree best.

#include <span>

#include "core/rig_types.h"

namespace wheatstone {

/// Plane perpendicular to the reference pose's axis, at the depth in near_mm..far_mm where the
/// views nearest to that pose disagree least (mean absolute deviation of gamma-encoded luminance
/// between the views, truncated against occlusion, over about 20 000 rays). The sweep takes
/// `steps` depths evenly in 1/depth, then a parabola through the best and its neighbours; depths
/// at which less than a third of the rays are seen by two views do not count. Only the views are
/// looked at; no picture at the reference pose is needed.
/// Errors: ArgumentError unless 0 < near < far, steps >= 3, at least two views; when no depth
/// counts.
PlaneInWorld find_focal_plane(std::span<const LightFieldView>,
                              const RigidTransform& T_reference_world, double near_mm,
                              double far_mm, int steps);

}  // namespace wheatstone
