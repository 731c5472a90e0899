#include "core/geometry.h"

#include <Eigen/LU>
#include <cmath>

#include "core/error.h"

namespace wheatstone {

Eigen::Vector2d distort(const Distortion& d, const Eigen::Vector2d& xy) {
  const double x = xy.x(), y = xy.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3));
  return {x * radial + 2 * d.p1 * x * y + d.p2 * (r2 + 2 * x * x),
          y * radial + d.p1 * (r2 + 2 * y * y) + 2 * d.p2 * x * y};
}

namespace {
Eigen::Matrix2d distort_jacobian(const Distortion& d, const Eigen::Vector2d& xy) {
  const double x = xy.x(), y = xy.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3));
  const double slope = 2 * (d.k1 + r2 * (2 * d.k2 + r2 * 3 * d.k3));  // d radial / d r2, times 2
  Eigen::Matrix2d J;
  J << radial + x * x * slope + 2 * d.p1 * y + 6 * d.p2 * x,
      x * y * slope + 2 * d.p1 * x + 2 * d.p2 * y, x * y * slope + 2 * d.p1 * x + 2 * d.p2 * y,
      radial + y * y * slope + 6 * d.p1 * y + 2 * d.p2 * x;
  return J;
}
}  // namespace

Eigen::Vector2d undistort(const Distortion& d, const Eigen::Vector2d& xy) {
  if (d.is_zero()) return xy;
  Eigen::Vector2d u = xy;
  for (int i = 0; i < 50; ++i) {
    const Eigen::Matrix2d J = distort_jacobian(d, u);
    if (!(J.determinant() > 0)) break;
    const Eigen::Vector2d step = J.inverse() * (distort(d, u) - xy);
    u -= step;
    if (step.norm() < 1e-13) return u;
  }
  throw ArgumentError("a point lies beyond the fold of the lens distortion model",
                      "check the distortion coefficients or crop the image");
}

Eigen::Vector2d project(const Intrinsics& k, const Distortion& d, const Eigen::Vector3d& p) {
  if (!(p.z() > 0))
    throw ArgumentError("a point behind the camera cannot be projected",
                        "check the pose and its convention");
  const Eigen::Vector2d xy = distort(d, {p.x() / p.z(), p.y() / p.z()});
  return {k.fx_px * xy.x() + k.skew_px * xy.y() + k.cx_px, k.fy_px * xy.y() + k.cy_px};
}

Eigen::Matrix<double, 3, 4> projection_matrix(const Eigen::Matrix3d& K, const RigidTransform& T) {
  Eigen::Matrix<double, 3, 4> Rt;
  Rt << T.R, T.t_mm;
  return K * Rt;
}

Eigen::Vector2d project(const Eigen::Matrix<double, 3, 4>& P, const Eigen::Vector3d& p) {
  const Eigen::Vector3d h = P * p.homogeneous();
  if (h.z() == 0)
    throw ArgumentError("a point in the plane of the camera centre cannot be projected",
                        "check the pose and its convention");
  return h.hnormalized();
}

cv::Matx33d to_cv(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

Eigen::Matrix3d to_eigen(const cv::Matx33d& m) {
  return (Eigen::Matrix3d() << m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0),
          m(2, 1), m(2, 2))
      .finished();
}

}  // namespace wheatstone
