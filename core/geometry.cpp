#include "core/geometry.h"

#include <Eigen/LU>
#include <cmath>

#include "core/error.h"

namespace wheatstone {

Eigen::Vector2d distort(const Distortion& d, const Eigen::Vector2d& xy) {
  return distort(d.coefficients().data(), d.fisheye, xy.x(), xy.y());
}

namespace {

/// The factor g(r^2) that a radial model scales a point with, and 2 dg / d(r^2).
struct RadialGain {
  double gain, slope;
};

RadialGain radial_gain(const Distortion& d, double r2) {
  if (!d.fisheye) {
    const double above = 1 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3));
    const double below = 1 + r2 * (d.k4 + r2 * (d.k5 + r2 * d.k6));
    const double above_slope = d.k1 + r2 * (2 * d.k2 + r2 * 3 * d.k3);
    const double below_slope = d.k4 + r2 * (2 * d.k5 + r2 * 3 * d.k6);
    return {above / below, 2 * (above_slope * below - above * below_slope) / (below * below)};
  }
  if (r2 < 1e-10) return {1 + r2 * (d.k1 - 1.0 / 3), 2 * (d.k1 - 1.0 / 3)};  // series of atan
  const double r = std::sqrt(r2), t = std::atan(r), t2 = t * t;
  const double radius = t * (1 + t2 * (d.k1 + t2 * (d.k2 + t2 * (d.k3 + t2 * d.k4))));
  const double radius_slope =
      (1 + t2 * (3 * d.k1 + t2 * (5 * d.k2 + t2 * (7 * d.k3 + t2 * 9 * d.k4)))) / (1 + r2);
  return {radius / r, (radius_slope - radius / r) / r2};
}

Eigen::Matrix2d distort_jacobian(const Distortion& d, const Eigen::Vector2d& xy) {
  const double x = xy.x(), y = xy.y();
  const RadialGain g = radial_gain(d, xy.squaredNorm());
  const double p1 = d.fisheye ? 0 : d.p1, p2 = d.fisheye ? 0 : d.p2;
  const double mixed = x * y * g.slope + 2 * p1 * x + 2 * p2 * y;
  Eigen::Matrix2d J;
  J << g.gain + x * x * g.slope + 2 * p1 * y + 6 * p2 * x, mixed, mixed,
      g.gain + y * y * g.slope + 6 * p1 * y + 2 * p2 * x;
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
