#include "calib/eye_solver.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Dense>
#include <cmath>
#include <string>

#include "core/error.h"

namespace wheatstone {
namespace {

using Matrix34 = Eigen::Matrix<double, 3, 4>;
constexpr const char* kRemedy =
    "use marks on two planes: 4 near crosses and 4 marker LEDs, spread over the view";
// Ratios of singular values. The rig's two planes of 4 marks give 0.29 and 0.19.
constexpr double kMinDepthSpread = 0.01;
constexpr double kMinDltRatio = 1e-3;

/// Similarity that moves points to the origin with mean distance sqrt(N).
template <int N>
Eigen::Matrix<double, N + 1, N + 1> normaliser(const Eigen::Matrix<double, N, Eigen::Dynamic>& p) {
  const Eigen::Matrix<double, N, 1> mean = p.rowwise().mean();
  const double distance = (p.colwise() - mean).colwise().norm().mean();
  if (!(distance > 0) || !std::isfinite(distance))
    throw ArgumentError("all marks fall on one point", kRemedy);
  const double scale = std::sqrt(double(N)) / distance;
  Eigen::Matrix<double, N + 1, N + 1> T = Eigen::Matrix<double, N + 1, N + 1>::Identity();
  T.template topLeftCorner<N, N>() *= scale;
  T.template topRightCorner<N, 1>() = -scale * mean;
  return T;
}

Matrix34 dlt(std::span<const Alignment> marks, const std::string& name) {
  const auto n = static_cast<Eigen::Index>(marks.size());
  Eigen::Matrix3Xd world(3, n);
  Eigen::Matrix2Xd pixel(2, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    world.col(i) = marks[static_cast<std::size_t>(i)].p_rsb_mm;
    pixel.col(i) = marks[static_cast<std::size_t>(i)].lcd_px;
  }
  const Eigen::Matrix4d T_world = normaliser<3>(world);
  const Eigen::Matrix3d T_pixel = normaliser<2>(pixel);
  const Eigen::Vector3d spread =
      Eigen::JacobiSVD<Eigen::MatrixXd>(world.colwise() - world.rowwise().mean().eval())
          .singularValues();
  if (spread[2] < kMinDepthSpread * spread[0])
    throw ArgumentError(name + ": all " + std::to_string(n) + " marks lie on one plane", kRemedy);

  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * n, 12);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::RowVector4d X = (T_world * world.col(i).homogeneous()).transpose();
    const Eigen::Vector3d u = T_pixel * pixel.col(i).homogeneous();
    A.block<1, 4>(2 * i, 0) = X;
    A.block<1, 4>(2 * i, 8) = -u.x() * X;
    A.block<1, 4>(2 * i + 1, 4) = X;
    A.block<1, 4>(2 * i + 1, 8) = -u.y() * X;
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeFullV);
  const Eigen::VectorXd s = svd.singularValues();
  if (!(s[10] > kMinDltRatio * s[0]))
    throw ArgumentError(name + ": the marks do not determine the projection (degenerate layout)",
                        kRemedy);
  const Eigen::VectorXd h = svd.matrixV().col(11);
  Matrix34 P;
  P << h.segment<4>(0).transpose(), h.segment<4>(4).transpose(), h.segment<4>(8).transpose();
  return T_pixel.inverse() * P * T_world;
}

struct Decomposed {
  Eigen::Matrix3d K, R;
  Eigen::Vector3d centre_mm;
};

/// RQ of the left 3x3 block. Pre: all marks have positive depth under P.
Decomposed decompose(const Matrix34& P, const std::string& name) {
  const Eigen::Matrix3d M = P.leftCols<3>();
  if (!(M.determinant() > 0))
    throw ArgumentError(name + ": the aligned pixels are a mirror image of the marks",
                        "check whether the LCD image is flipped and whether left and right or "
                        "top and bottom marks were swapped");
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
  J(0, 2) = J(1, 1) = J(2, 0) = 1;
  const Eigen::HouseholderQR<Eigen::Matrix3d> qr((J * M).transpose());
  const Eigen::Matrix3d upper = qr.matrixQR().triangularView<Eigen::Upper>();
  Decomposed out;
  out.K = J * upper.transpose() * J;
  out.R = J * Eigen::Matrix3d(qr.householderQ()).transpose();
  for (int i = 0; i < 3; ++i)
    if (out.K(i, i) < 0) {
      out.K.col(i) *= -1;
      out.R.row(i) *= -1;
    }
  out.K /= out.K(2, 2);
  out.centre_mm = -(M.inverse() * P.col(3));
  return out;
}

struct Reprojection {
  Eigen::Matrix3d R_start;
  Alignment mark;

  template <class T>
  bool operator()(const T* k, const T* turn, const T* centre, T* residual) const {
    const Eigen::Matrix<T, 3, 1> offset(T(mark.p_rsb_mm.x()) - centre[0],
                                        T(mark.p_rsb_mm.y()) - centre[1],
                                        T(mark.p_rsb_mm.z()) - centre[2]);
    const Eigen::Matrix<T, 3, 1> start = R_start.cast<T>() * offset;
    T p[3];
    ceres::AngleAxisRotatePoint(turn, start.data(), p);
    if (!(p[2] > T(0))) return false;
    residual[0] = (k[0] * p[0] + k[2] * p[1]) / p[2] + k[3] - mark.lcd_px.x();
    residual[1] = k[1] * p[1] / p[2] + k[4] - mark.lcd_px.y();
    return true;
  }
};

}  // namespace

EyeDisplayCalibration solve_eye_display(DisplayId id, std::span<const Alignment> marks,
                                        int lcd_width_px, int lcd_height_px) {
  const std::string name = to_string(id);
  if (marks.size() < 6)
    throw ArgumentError(
        name + ": " + std::to_string(marks.size()) + " marks, but a projection needs 6", kRemedy);
  for (const Alignment& m : marks)
    if (!m.p_rsb_mm.allFinite() || !m.lcd_px.allFinite())
      throw ArgumentError(name + ": a mark has no finite position", "repeat the alignment");

  Matrix34 P = dlt(marks, name);
  std::size_t in_front = 0;
  for (const Alignment& m : marks) in_front += P.row(2).dot(m.p_rsb_mm.homogeneous()) > 0;
  if (in_front < marks.size() && in_front > 0)
    throw ArgumentError(name + ": some marks come out behind the eye",
                        "check that no two marks were swapped and repeat the alignment");
  if (in_front == 0) P = -P;  // the DLT leaves the sign open
  const Decomposed start = decompose(P, name);

  double k[5] = {start.K(0, 0), start.K(1, 1), start.K(0, 1), start.K(0, 2), start.K(1, 2)};
  double turn[3] = {0, 0, 0};
  Eigen::Vector3d centre = start.centre_mm;
  ceres::Problem problem;
  for (const Alignment& m : marks)
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Reprojection, 2, 5, 3, 3>(new Reprojection{start.R, m}),
        nullptr, k, turn, centre.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 200;
  options.function_tolerance = options.parameter_tolerance = 1e-14;
  options.gradient_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable() || !(k[0] > 0) || !(k[1] > 0))
    throw ArgumentError(name + ": no eye position explains the marks (" + summary.message + ")",
                        "repeat the alignment; " + std::string(kRemedy));

  EyeDisplayCalibration out;
  out.id = id;
  out.intrinsics = {k[0], k[1], k[2], k[3], k[4], lcd_width_px, lcd_height_px};
  Eigen::Matrix3d R_turn;
  ceres::AngleAxisToRotationMatrix(turn, R_turn.data());
  out.T_eye_rsb.R = R_turn * start.R;
  out.T_eye_rsb.t_mm = -(out.T_eye_rsb.R * centre);
  out.P_lcd_rsb = projection_matrix(out.intrinsics.K(), out.T_eye_rsb);
  double sum = 0;
  for (const Alignment& m : marks) {
    out.residuals_px.push_back(project(out.P_lcd_rsb, m.p_rsb_mm) - m.lcd_px);
    sum += out.residuals_px.back().squaredNorm();
  }
  out.rms_px = std::sqrt(sum / static_cast<double>(marks.size()));
  return out;
}

}  // namespace wheatstone
