#include "calib/camera_bundle.h"

#include <glog/logging.h>

#include <Eigen/Dense>
#include <algorithm>

#include "core/error.h"

namespace wheatstone::detail {
namespace {

constexpr double kMinSingularRatio = 1e-10;

}  // namespace

CameraBlock camera_block(const Intrinsics& k, const Distortion& d) {
  CameraBlock block = {k.fx_px, k.fy_px, k.cx_px, k.cy_px};
  const auto c = d.coefficients();
  std::copy(c.begin(), c.end(), block.begin() + 4);
  return block;
}

void set_camera(const CameraBlock& b, Intrinsics& k, Distortion& d) {
  k.fx_px = b[0], k.fy_px = b[1], k.cx_px = b[2], k.cy_px = b[3];
  d = {b[4], b[5], b[6], b[7], b[8], b[9], b[10], b[11], d.fisheye};
}

std::vector<int> free_parameters(DistortionModel model) {
  switch (model) {
    case DistortionModel::kRadtan4:
      return {0, 1, 2, 3, 4, 5, 6, 7};
    case DistortionModel::kRadtan5:
      return {0, 1, 2, 3, 4, 5, 6, 7, 8};
    case DistortionModel::kRadtan8:
      return {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
    case DistortionModel::kFisheye:
      return {0, 1, 2, 3, 4, 5, 8, 9};
  }
  throw InternalError("no such distortion model");
}

ceres::Manifold* camera_manifold(DistortionModel model) {
  const std::vector<int> free = free_parameters(model);
  std::vector<int> fixed;
  for (int i = 0; i < 12; ++i)
    if (std::find(free.begin(), free.end(), i) == free.end()) fixed.push_back(i);
  return fixed.empty() ? nullptr : new ceres::SubsetManifold(12, fixed);
}

RigidTransform PoseBlock::transform() const {
  Eigen::Matrix3d turn;
  ceres::AngleAxisToRotationMatrix(turn_t.data(), turn.data());
  return {turn * R_start, Eigen::Map<const Eigen::Vector3d>(turn_t.data() + 3)};
}

void SharedInformation::add_board(const Eigen::MatrixXd& J_shared, const Eigen::MatrixXd& J_board,
                                  const Eigen::VectorXd& residuals, Eigen::Index pictures) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(J_board);
  const Eigen::MatrixXd Q =
      qr.householderQ() * Eigen::MatrixXd::Identity(J_board.rows(), qr.rank());
  const Eigen::MatrixXd reduced = J_shared - Q * (Q.transpose() * J_shared);
  const Eigen::Index rows = residuals.size() / pictures;
  for (Eigen::Index i = 0; i < pictures; ++i) {
    const Eigen::Map<const Eigen::Matrix2Xd> corners(residuals.data() + i * rows, 2, rows / 2);
    pictures_.push_back({reduced.middleRows(i * rows, rows), corners * corners.transpose(),
                         static_cast<double>(rows) - Q.middleRows(i * rows, rows).squaredNorm()});
  }
}

Eigen::MatrixXd SharedInformation::normal() const {
  Eigen::MatrixXd sum = pictures_[0].J.transpose() * pictures_[0].J;
  for (std::size_t i = 1; i < pictures_.size(); ++i)
    sum += pictures_[i].J.transpose() * pictures_[i].J;
  return sum;
}

Eigen::MatrixXd SharedInformation::covariance() const {
  Eigen::Index rows = 0;
  for (const Picture& p : pictures_) rows += p.J.rows();
  const Eigen::Index shared = pictures_[0].J.cols();
  Eigen::MatrixXd all(rows, shared);
  Eigen::Index row = 0;
  for (const Picture& p : pictures_) {
    all.middleRows(row, p.J.rows()) = p.J;
    row += p.J.rows();
  }
  // The parameters differ in scale by many powers of ten; with columns of unit length the singular
  // values tell what is determined. Those of J and not of J^T J, where squaring would lose what
  // the rational model barely determines.
  const Eigen::VectorXd scale = all.colwise().norm().cwiseInverse().transpose();
  if (!scale.allFinite() || rows < shared) return {};
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(all * scale.asDiagonal(), Eigen::ComputeThinV);
  const Eigen::VectorXd s = svd.singularValues();
  if (!(s[shared - 1] > kMinSingularRatio * s[0])) return {};
  // (J^T J)^-1 = root root^T, and J root has orthonormal columns: its squares are leverages.
  const Eigen::MatrixXd root = scale.asDiagonal() * svd.matrixV() * s.cwiseInverse().asDiagonal();
  const Eigen::Matrix2d pooled = std::pow(corner_sigma_px(), 2) * Eigen::Matrix2d::Identity();
  Eigen::MatrixXd middle = Eigen::MatrixXd::Zero(shared, shared);
  for (const Picture& p : pictures_) {
    const Eigen::MatrixXd U = p.J * root;
    const double freedom = p.freedom - U.squaredNorm();
    const Eigen::Matrix2d noise = freedom < 1 ? pooled : 2 / freedom * p.scatter;
    for (Eigen::Index i = 0; i < U.rows(); i += 2)
      middle += U.middleRows<2>(i).transpose() * noise * U.middleRows<2>(i);
  }
  return root * middle * root.transpose();
}

double SharedInformation::corner_sigma_px() const {
  double squares = 0, freedom = -static_cast<double>(pictures_[0].J.cols());
  for (const Picture& p : pictures_) squares += p.scatter.trace(), freedom += p.freedom;
  return std::sqrt(squares / freedom);
}

void solve_to_end(ceres::Problem& problem, const std::string& what, const std::string& remedy) {
  // Ceres logs each failed step as a warning, whatever its logging_type; the summary has the
  // outcome.
  static const bool quiet = [] {
    FLAGS_minloglevel = google::GLOG_ERROR;
    return true;
  }();
  static_cast<void>(quiet);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 100;
  options.function_tolerance = options.parameter_tolerance = 1e-12;
  options.gradient_tolerance = 1e-10;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable())
    throw ArgumentError(what + " does not converge: " + summary.message, remedy);
}

}  // namespace wheatstone::detail
