#include "calib/rail.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr double kLeastScale = 0.1;  // travel per mm of a rail that moves at all

/// travel = scale position + offset.
struct Line {
  double scale = 0, offset = 0;
  double error(double position, double travel) const { return travel - scale * position - offset; }
};

Line least_squares(const std::vector<std::size_t>& views, std::span<const double> positions,
                   const Eigen::VectorXd& travel) {
  double p = 0, t = 0, pp = 0, pt = 0;
  const auto n = static_cast<double>(views.size());
  for (const std::size_t v : views)
    p += positions[v] / n, t += travel[static_cast<Eigen::Index>(v)] / n;
  for (const std::size_t v : views) {
    pp += (positions[v] - p) * (positions[v] - p);
    pt += (positions[v] - p) * (travel[static_cast<Eigen::Index>(v)] - t);
  }
  return {pt / pp, t - pt / pp * p};
}

/// The views that agree with the line, with the sum of their errors.
struct Agreement {
  std::vector<std::size_t> views;
  double errors_mm = 0;
};

Agreement agreement(const Line& line, std::span<const double> positions,
                    const Eigen::VectorXd& travel, double tolerance_mm) {
  Agreement out;
  for (std::size_t v = 0; v < positions.size(); ++v)
    if (const double e = std::abs(line.error(positions[v], travel[static_cast<Eigen::Index>(v)]));
        e <= tolerance_mm)
      out.views.push_back(v), out.errors_mm += e;
  return out;
}

}  // namespace

std::vector<MisplacedView> misplaced_views(std::span<const Eigen::Vector3d> centres,
                                           std::span<const double> positions_mm,
                                           double tolerance_mm) {
  const std::size_t n = centres.size();
  if (n != positions_mm.size())
    throw ArgumentError(std::to_string(n) + " camera centres and " +
                            std::to_string(positions_mm.size()) + " positions make no rail",
                        "give one position per view");
  if (n < 3) return {};
  Eigen::Matrix3Xd offset(3, static_cast<Eigen::Index>(n));
  for (std::size_t v = 0; v < n; ++v) offset.col(static_cast<Eigen::Index>(v)) = centres[v];
  offset.colwise() -= offset.rowwise().mean().eval();
  const Eigen::JacobiSVD<Eigen::Matrix3Xd> svd(offset, Eigen::ComputeFullU);
  const Eigen::VectorXd travel = offset.transpose() * svd.matrixU().col(0);

  Agreement best;
  bool moves = false;
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = a + 1; b < n; ++b) {
      if (positions_mm[a] == positions_mm[b]) continue;
      moves = true;
      Agreement other = agreement(least_squares({a, b}, positions_mm, travel), positions_mm, travel,
                                  tolerance_mm);
      if (other.views.size() > best.views.size() ||
          (other.views.size() == best.views.size() && other.errors_mm < best.errors_mm))
        best = std::move(other);
    }
  if (!moves) return {};
  const char* const remedy = "check that each marker frame belongs to its view, and the encoder";
  if (best.views.size() < std::max<std::size_t>(3, n / 2 + 1))
    throw ArgumentError(
        "the views do not stand where the rail reported them, and no majority "
        "agrees on the rail",
        remedy);
  const Line line = least_squares(best.views, positions_mm, travel);
  if (std::abs(line.scale) < kLeastScale)
    throw ArgumentError("the camera stays in one place while the rail reports that it moved",
                        remedy);
  std::vector<MisplacedView> out;
  for (std::size_t v = 0; v < n; ++v) {
    const double along = travel[static_cast<Eigen::Index>(v)];
    if (std::abs(line.error(positions_mm[v], along)) > tolerance_mm)
      out.push_back({v, (along - line.offset) / line.scale, positions_mm[v]});
  }
  return out;
}

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
