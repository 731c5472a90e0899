#include "calib/camera_bundle.h"

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

SharedInformation::SharedInformation(Eigen::Index shared)
    : parameters_(static_cast<double>(shared)),
      upper_(Eigen::MatrixXd::Zero(shared, shared)),
      scores_(Eigen::MatrixXd::Zero(shared, shared)) {}

void SharedInformation::add_board(const Eigen::MatrixXd& J_shared, const Eigen::MatrixXd& J_board,
                                  const Eigen::VectorXd& residuals) {
  residuals_ += static_cast<double>(residuals.size());
  parameters_ += 6;
  squares_ += residuals.squaredNorm();
  const Eigen::MatrixXd reduced =
      J_shared - J_board * J_board.colPivHouseholderQr().solve(J_shared);
  const Eigen::Index shared = upper_.cols();
  Eigen::MatrixXd stacked(shared + reduced.rows(), shared);
  stacked << upper_, reduced;
  const Eigen::MatrixXd qr = stacked.householderQr().matrixQR();
  upper_ = qr.topRows(shared).triangularView<Eigen::Upper>();
  for (Eigen::Index i = 0; i < residuals.size(); i += 2) {
    const Eigen::VectorXd score = reduced.middleRows<2>(i).transpose() * residuals.segment<2>(i);
    scores_ += score * score.transpose();
  }
}

Eigen::MatrixXd SharedInformation::covariance() const {
  // The parameters differ in scale by many powers of ten; with columns of unit length the singular
  // values tell what is determined.
  const Eigen::VectorXd scale = upper_.colwise().norm().cwiseInverse().transpose();
  if (!scale.allFinite()) return {};
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(upper_ * scale.asDiagonal(), Eigen::ComputeThinV);
  const Eigen::VectorXd s = svd.singularValues();
  if (!(s[s.size() - 1] > kMinSingularRatio * s[0])) return {};
  const Eigen::MatrixXd root = scale.asDiagonal() * svd.matrixV() * s.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd inverse = root * root.transpose();
  return residuals_ / (residuals_ - parameters_) * inverse * scores_ * inverse;
}

double SharedInformation::corner_sigma_px() const {
  return std::sqrt(squares_ / (residuals_ - parameters_));
}

void solve_to_end(ceres::Problem& problem, const std::string& what, const std::string& remedy) {
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
