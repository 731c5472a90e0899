#pragma once
// Rigid transforms and pinhole cameras. Names carry both frames: T_camera_rsb takes coordinates
// in `rsb` to coordinates in `camera` (docs/conventions.md).

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

namespace wheatstone {

/// p_a = R p_b + t_mm for a variable named T_a_b.
struct RigidTransform {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_mm = Eigen::Vector3d::Zero();

  RigidTransform inverse() const { return {R.transpose(), -(R.transpose() * t_mm)}; }
  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return R * p + t_mm; }
  RigidTransform operator*(const RigidTransform& T_b_c) const {
    return {R * T_b_c.R, R * T_b_c.t_mm + t_mm};
  }
};

/// Where the camera stands: the centre of projection in the frame `a` of T_camera_a.
inline Eigen::Vector3d camera_centre(const RigidTransform& T_camera_a) {
  return -(T_camera_a.R.transpose() * T_camera_a.t_mm);
}

/// The orientation of a camera that looks straight into the box: rsb is x right, y up, z towards
/// the viewer; a camera is x right, y down, z forward.
inline Eigen::Matrix3d straight_R_camera_rsb() {
  return Eigen::Vector3d(1, -1, -1).asDiagonal();
}

/// Pinhole intrinsics in pixels (OpenCV's pixel convention) and the size they belong to.
struct Intrinsics {
  double fx_px = 0, fy_px = 0, skew_px = 0, cx_px = 0, cy_px = 0;
  int width_px = 0, height_px = 0;

  Eigen::Matrix3d K() const {
    return (Eigen::Matrix3d() << fx_px, skew_px, cx_px, 0, fy_px, cy_px, 0, 0, 1).finished();
  }
};

/// Radial-tangential distortion with OpenCV's meaning of k1, k2, p1, p2, k3, on normalised
/// coordinates x = X/Z, y = Y/Z.
struct Distortion {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;
  bool is_zero() const { return k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0 && k3 == 0; }
};

/// Normalised undistorted to normalised distorted coordinates.
Eigen::Vector2d distort(const Distortion&, const Eigen::Vector2d& xy);

/// Inverse of distort() by Newton iteration to 1e-12. Throws ArgumentError when (x, y) lies
/// beyond the fold of the model, where no inverse exists.
Eigen::Vector2d undistort(const Distortion&, const Eigen::Vector2d& xy);

/// A point in the camera frame to pixels. Pre: p_camera.z() > 0, else ArgumentError.
Eigen::Vector2d project(const Intrinsics&, const Distortion&, const Eigen::Vector3d& p_camera);

/// P_pixel_a = K [R | t], 3x4: homogeneous points in `a` to homogeneous pixels.
Eigen::Matrix<double, 3, 4> projection_matrix(const Eigen::Matrix3d& K,
                                              const RigidTransform& T_camera_a);

/// Homogeneous divide of P (p, 1). Pre: the third entry is not 0, else ArgumentError.
Eigen::Vector2d project(const Eigen::Matrix<double, 3, 4>& P_pixel_a, const Eigen::Vector3d& p_a);

/// cv::Mat and Eigen meet here and nowhere else.
cv::Matx33d to_cv(const Eigen::Matrix3d&);
Eigen::Matrix3d to_eigen(const cv::Matx33d&);

}  // namespace wheatstone
