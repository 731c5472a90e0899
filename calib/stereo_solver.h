#pragma once
// Two cameras that see the same boards: where one stands from the other.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "calib/camera_solver.h"

namespace wheatstone {

struct StereoCalibration {
  /// Intrinsics, distortion, their covariance and this camera's residuals of the joint solution;
  /// T_camera_board of the left camera's own frame and of the right's.
  CameraCalibration left, right;
  RigidTransform T_right_left;
  /// Of a small turn (rad) of the right camera about its own axes, and of T_right_left.t_mm.
  Eigen::Matrix<double, 6, 6> T_right_left_covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double baseline_mm = 0, baseline_sigma_mm = 0;  // distance between the centres of projection
  double rms_px = 0;                              // over both cameras
};

/// Joint least squares of both cameras, the transform between them and one pose per board.
/// Pictures left[i] and right[i] show the same board at the same moment. A finder may start a board
/// at either end of its diagonal; the order that fits the other pairs is taken. Covariances as in
/// solve_camera(). Throws ArgumentError as solve_camera(), and for lists of different lengths.
StereoCalibration solve_stereo(std::span<const BoardView> left, std::span<const BoardView> right,
                               const Board&, int width_px, int height_px,
                               DistortionModel = DistortionModel::kRadtan5);

}  // namespace wheatstone
