#pragma once
// Camera poses from images of known markers: one start per view (pnp.h), then one bundle of all.

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "core/geometry.h"

namespace wheatstone {

/// Where a marker was seen, distorted pixels, and how well.
struct MarkerSighting {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();
};

struct PoseOptions {
  /// The carriage slides along a straight rail and does not turn: all views have one rotation, and
  /// the centres between the two outermost lie on their line to within rail_straightness_mm.
  /// Without it every view has its own six parameters.
  bool straight_rail = true;
  double rail_straightness_mm = 0.05;  // standard deviation, per axis across the rail
};

struct PoseSolution {
  std::vector<RigidTransform> T_camera_rsb;  // one per view
  /// One per view, of a small turn of the camera about its own axes (rad; first three) and of
  /// camera_centre() in rsb (mm).
  std::vector<Eigen::Matrix<double, 6, 6>> covariance;
  std::vector<std::vector<Eigen::Vector2d>> residuals_px;  // predicted - seen, [view][marker]
  std::vector<double> view_rms_px;
  double rms_px = 0;       // root mean square length of the residuals
  double rms_free_px = 0;  // the same with a rotation for each view
  /// Standard deviation of a residual per axis and degree of freedom, with one rotation and with a
  /// rotation for each view, both without the straightness prior: a second much smaller than the
  /// first means that the carriage does turn.
  double scatter_px = 0, scatter_free_px = 0;
  /// The residuals' size in units of what the sightings' covariances predict, made larger by what
  /// is in doubt about it (Student's t). The pose covariances are scaled by its square: with 8 or
  /// more degrees of freedom by the residuals alone, with fewer by at least 1.
  double noise_factor = 1;
  /// Centres without the straightness prior (but with one rotation): to judge the rail by.
  std::vector<Eigen::Vector3d> free_centres_rsb;
  std::string report;  // one line for people

  Eigen::Matrix3d centre_covariance_mm2(std::size_t view) const {
    return covariance[view].bottomRightCorner<3, 3>();
  }
};

/// Poses of all views, weighted by the sightings' covariances. `markers_rsb` in mm;
/// `seen_per_view[v][m]` is marker m in view v. The intrinsics are kept and taken as exact.
/// Throws ArgumentError when there is no view, when there are fewer than four markers or they lie
/// on a line, when a view has another number of points or a sighting without a covariance, or when
/// no pose explains a view; the message names the view by its index.
PoseSolution solve_poses(std::span<const Eigen::Vector3d> markers_rsb,
                         std::span<const std::vector<MarkerSighting>> seen_per_view,
                         const Intrinsics&, const Distortion&, const PoseOptions& = {});

/// Standard deviation in px that a pose's covariance leaves in the image of the plane
/// z = plane_z_mm of rsb: root of the summed variances of x and y, root mean square over a 5 x 5
/// grid of points between min_mm and max_mm (x, y in rsb). Throws ArgumentError if the plane is
/// not in front of the camera.
double plane_uncertainty_px(const RigidTransform& T_camera_rsb,
                            const Eigen::Matrix<double, 6, 6>& covariance, const Intrinsics&,
                            const Distortion&, double plane_z_mm, const Eigen::Vector2d& min_mm,
                            const Eigen::Vector2d& max_mm);

}  // namespace wheatstone
