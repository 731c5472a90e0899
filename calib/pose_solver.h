#pragma once
// Camera poses from images of known markers: one start per view (IPPE), then one bundle of all.

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "core/geometry.h"

namespace wheatstone {

struct PoseOptions {
  /// The carriage slides along a rail and does not turn, so all views have one rotation; three
  /// angles from all views leave the centres far better determined than three angles each.
  bool share_rotation = true;
  /// Expected standard deviation of a centroid per axis; scales the covariance. If the residuals
  /// are larger than this, they scale it instead.
  double centroid_sigma_px = 0.03;
};

struct PoseSolution {
  std::vector<RigidTransform> T_camera_rsb;                // one per view
  std::vector<Eigen::Matrix3d> centre_covariance_mm2;      // of camera_centre(), in rsb
  std::vector<std::vector<Eigen::Vector2d>> residuals_px;  // predicted - seen, [view][marker]
  double rms_px = 0;       // root mean square length of the residuals
  double rms_free_px = 0;  // the same with one rotation per view: much smaller than rms_px means
                           // that the carriage does turn
  std::string report;      // one line for people
};

/// Poses of all views. `markers_rsb` in mm; `seen_px_per_view[v][m]` is marker m in view v in
/// distorted pixels. The intrinsics are kept. Throws ArgumentError when there is no view, when
/// there are fewer than four markers or they lie on a line, when a view has another number of
/// points, or when no pose explains a view; the message names the view.
PoseSolution solve_poses(std::span<const Eigen::Vector3d> markers_rsb,
                         std::span<const std::vector<Eigen::Vector2d>> seen_px_per_view,
                         const Intrinsics&, const Distortion&, const PoseOptions& = {});

}  // namespace wheatstone
