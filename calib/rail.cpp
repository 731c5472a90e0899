#include "calib/rail.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace wheatstone {

RailReport report_rail(std::span<const Eigen::Vector3d> centres,
                       std::span<const double> positions_mm) {
  const auto n = static_cast<Eigen::Index>(centres.size());
  if (n < 2 || centres.size() != positions_mm.size())
    throw ArgumentError(std::to_string(centres.size()) + " camera centres and " +
                            std::to_string(positions_mm.size()) + " positions make no rail",
                        "give one position per view, and at least two views");
  const Eigen::Map<const Eigen::VectorXd> asked(positions_mm.data(), n);
  if (!(asked.maxCoeff() > asked.minCoeff()))
    throw ArgumentError("all views stand at one position of the rail", "move between the views");
  Eigen::Matrix3Xd offset(3, n);
  for (Eigen::Index i = 0; i < n; ++i) offset.col(i) = centres[static_cast<std::size_t>(i)];
  offset.colwise() -= offset.rowwise().mean().eval();
  RailReport report;
  const Eigen::JacobiSVD<Eigen::Matrix3Xd> svd(offset, Eigen::ComputeFullU);
  report.direction_rsb = svd.matrixU().col(0);
  const Eigen::VectorXd centred = asked.array() - asked.mean();
  Eigen::VectorXd along = offset.transpose() * report.direction_rsb;
  if (along.dot(centred) < 0) {
    report.direction_rsb *= -1;
    along *= -1;
  }
  const Eigen::Matrix3Xd off_line = offset - report.direction_rsb * along.transpose();
  const Eigen::VectorXd across = off_line.colwise().norm();
  report.straightness_rms_mm = std::sqrt(across.squaredNorm() / static_cast<double>(n));
  report.straightness_largest_mm = across.maxCoeff();
  report.scale = along.dot(centred) / centred.squaredNorm();
  const Eigen::VectorXd error = along - report.scale * centred;
  report.step_error_rms_mm = std::sqrt(error.squaredNorm() / static_cast<double>(n));
  report.step_error_largest_mm = error.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < n; ++i) {
    report.off_line_mm.emplace_back(off_line.col(i));
    report.step_error_mm.push_back(error[i]);
  }
  report.pitch_mm = (along.maxCoeff() - along.minCoeff()) / static_cast<double>(n - 1);
  return report;
}

}  // namespace wheatstone
