#pragma once
// The pose of a camera from points it sees: the start of every refinement.

#include <Eigen/Core>
#include <span>
#include <string>

#include "core/geometry.h"

namespace wheatstone {

/// T_camera_a from points `p_a` and where the camera sees them, distorted pixels. On a plane by
/// IPPE (T. Collins and A. Bartoli, IJCV 2014), else by SQPnP; not refined on pixel distances.
/// Throws ArgumentError, beginning with `what`, when there are fewer than 4 points, when no pose
/// explains them, when a pixel lies beyond the fold of the distortion, or when a point comes out
/// behind the camera.
RigidTransform pose_from_points(std::span<const Eigen::Vector3d> p_a,
                                std::span<const Eigen::Vector2d> seen_px, const Intrinsics&,
                                const Distortion&, const std::string& what);

}  // namespace wheatstone
