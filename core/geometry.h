#pragma once
// Rigid transforms and pinhole cameras. Names carry both frames: T_camera_rsb takes coordinates
// in `rsb` to coordinates in `camera` (docs/conventions.md).

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
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

/// Lens distortion of normalised coordinates x = X/Z, y = Y/Z, r^2 = x^2 + y^2; the coefficients
/// mean what they mean in OpenCV. All 0 is a lens without distortion, unless it is a fisheye.
///   radial-tangential: (x, y) times (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6
///   r^6)
///                      plus the tangential part of p1 and p2
///   fisheye: atan(r) becomes the radius theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 +
///            k4 theta^8), theta = atan(r) (J. Kannala and S. Brandt, PAMI 2006); no p1, p2, k5, k6
struct Distortion {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0, k4 = 0, k5 = 0, k6 = 0;
  bool fisheye = false;

  std::array<double, 8> coefficients() const { return {k1, k2, p1, p2, k3, k4, k5, k6}; }
  /// True for a lens that leaves every point where it is.
  bool is_zero() const { return !fisheye && coefficients() == std::array<double, 8>{}; }
  /// True if k1, k2, p1, p2, k3 say it all.
  bool has_five_coefficients() const { return !fisheye && k4 == 0 && k5 == 0 && k6 == 0; }
};

/// Normalised undistorted to normalised distorted coordinates.
Eigen::Vector2d distort(const Distortion&, const Eigen::Vector2d& xy);

/// The same for any scalar T, and coefficients of the same or of double, so that solvers can
/// differentiate it. k: as coefficients().
template <class K, class T>
Eigen::Matrix<T, 2, 1> distort(const K* k, bool fisheye, const T& x, const T& y) {
  using std::atan, std::sqrt;
  const T r2 = x * x + y * y;
  if (fisheye) {
    if (!(r2 > T(1e-20))) return {x, y};
    const T r = sqrt(r2), theta = atan(r), t2 = theta * theta;
    const T scale = theta * (T(1) + t2 * (k[0] + t2 * (k[1] + t2 * (k[4] + t2 * k[5])))) / r;
    return {x * scale, y * scale};
  }
  const T radial = (T(1) + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) /
                   (T(1) + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
  return {x * radial + T(2) * k[2] * x * y + k[3] * (r2 + T(2) * x * x),
          y * radial + k[2] * (r2 + T(2) * y * y) + T(2) * k[3] * x * y};
}

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
