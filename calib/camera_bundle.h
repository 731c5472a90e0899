#pragma once
// Inside of the camera, stereo and uncertainty solvers: parameter blocks, residuals and the
// covariance of what all boards share.

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "calib/camera_solver.h"
#include "core/geometry.h"

namespace wheatstone::detail {

/// fx, fy, cx, cy and the eight coefficients of Distortion.
using CameraBlock = std::array<double, 12>;
CameraBlock camera_block(const Intrinsics&, const Distortion&);
void set_camera(const CameraBlock&, Intrinsics&, Distortion&);
/// Indices into a CameraBlock of what a model leaves free, in the order of the covariance.
std::vector<int> free_parameters(DistortionModel);
/// Holds the others where they are. Ceres takes ownership; nullptr when all are free.
ceres::Manifold* camera_manifold(DistortionModel);

/// A transform as a small turn (rad) before a fixed rotation, and a translation (mm):
/// T = (exp(turn) R_start, t). The turn stays away from the angle-axis singularity.
struct PoseBlock {
  Eigen::Matrix3d R_start = Eigen::Matrix3d::Identity();
  std::array<double, 6> turn_t = {};

  explicit PoseBlock(const RigidTransform& T)
      : R_start(T.R), turn_t{0, 0, 0, T.t_mm.x(), T.t_mm.y(), T.t_mm.z()} {}
  RigidTransform transform() const;
};

template <class T>
Eigen::Matrix<T, 3, 1> apply(const Eigen::Matrix3d& R_start, const T* turn_t,
                             const Eigen::Matrix<T, 3, 1>& p) {
  const Eigen::Matrix<T, 3, 1> start = R_start.cast<T>() * p;
  Eigen::Matrix<T, 3, 1> turned;
  ceres::AngleAxisRotatePoint(turn_t, start.data(), turned.data());
  return turned + Eigen::Map<const Eigen::Matrix<T, 3, 1>>(turn_t + 3);
}

/// Pixel of a point in the camera frame; false behind the camera.
template <class T>
bool project_px(const T* camera, bool fisheye, const Eigen::Matrix<T, 3, 1>& p, T* px) {
  if (!(p[2] > T(0))) return false;
  const Eigen::Matrix<T, 2, 1> xy = distort(camera + 4, fisheye, T(p[0] / p[2]), T(p[1] / p[2]));
  px[0] = camera[0] * xy[0] + camera[2];
  px[1] = camera[1] * xy[1] + camera[3];
  return true;
}

/// One corner seen by one camera. Residual: 2, predicted - seen, px.
struct CornerResidual {
  Eigen::Matrix3d R_start;
  Eigen::Vector3d p_board;
  Eigen::Vector2d seen_px;
  bool fisheye;

  template <class T>
  bool operator()(const T* camera, const T* T_camera_board, T* residual_px) const {
    const Eigen::Matrix<T, 3, 1> p = apply<T>(R_start, T_camera_board, p_board.cast<T>());
    if (!project_px(camera, fisheye, p, residual_px)) return false;
    residual_px[0] -= seen_px.x();
    residual_px[1] -= seen_px.y();
    return true;
  }
};
using CornerCost = ceres::AutoDiffCostFunction<CornerResidual, 2, 12, 6>;

/// Collects, board by board, what the residuals say about the shared parameters once each board's
/// own six are eliminated (Schur complement).
class SharedInformation {
 public:
  /// The board in `pictures` pictures of equally many rows, one after the other. J_shared: rows x
  /// shared, J_board: rows x 6, residuals: rows, in px.
  void add_board(const Eigen::MatrixXd& J_shared, const Eigen::MatrixXd& J_board,
                 const Eigen::VectorXd& residuals, Eigen::Index pictures = 1);
  /// J^T J of the shared parameters, boards eliminated; times 1 / sigma^2 it is their information.
  Eigen::MatrixXd normal() const;
  /// The sandwich estimate of solve_camera(). Empty when a combination of the parameters leaves
  /// all residuals as they are.
  Eigen::MatrixXd covariance() const;
  /// Standard deviation of a corner per axis, over all pictures.
  double corner_sigma_px() const;

 private:
  struct Picture {
    Eigen::MatrixXd J;  // by the shared parameters, what the board's pose can follow taken out
    Eigen::Matrix2d scatter;  // sum of the corners' residuals' outer products
    double freedom;           // residuals less what the board's pose spends on them
  };
  std::vector<Picture> pictures_;
};

/// Solves silently and to the end. Throws ArgumentError with `remedy` when nothing usable comes
/// out.
void solve_to_end(ceres::Problem&, const std::string& what, const std::string& remedy);

}  // namespace wheatstone::detail
