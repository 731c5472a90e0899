#include "calib/pose_solver.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <opencv2/calib3d.hpp>

#include "core/error.h"

namespace wheatstone {
namespace {

/// p_camera = exp(turn) R_start (p - centre): the turn stays small, away from the angle-axis
/// singularity that "straight into the box" (half a turn about x) sits on.
struct Reprojection {
  Eigen::Matrix3d R_start;
  Eigen::Vector3d p_rsb;
  Eigen::Vector2d seen_px;
  Intrinsics k;
  Distortion d;

  template <class T>
  bool operator()(const T* turn, const T* centre, T* residual) const {
    const Eigen::Matrix<T, 3, 1> offset(T(p_rsb.x()) - centre[0], T(p_rsb.y()) - centre[1],
                                        T(p_rsb.z()) - centre[2]);
    const Eigen::Matrix<T, 3, 1> start = R_start.cast<T>() * offset;
    T p[3];
    ceres::AngleAxisRotatePoint(turn, start.data(), p);
    if (!(p[2] > T(0))) return false;
    const T x = p[0] / p[2], y = p[1] / p[2], r2 = x * x + y * y;
    const T radial = 1.0 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3));
    const T xd = x * radial + 2.0 * d.p1 * x * y + d.p2 * (r2 + 2.0 * x * x);
    const T yd = y * radial + d.p1 * (r2 + 2.0 * y * y) + 2.0 * d.p2 * x * y;
    residual[0] = k.fx_px * xd + k.skew_px * yd + k.cx_px - seen_px.x();
    residual[1] = k.fy_px * yd + k.cy_px - seen_px.y();
    return true;
  }
};

struct Input {
  std::span<const Eigen::Vector3d> markers;
  std::span<const std::vector<Eigen::Vector2d>> seen;
  const Intrinsics& k;
  const Distortion& d;
};

std::string view_name(std::size_t v) {
  return "view " + std::to_string(v);
}

void check(const Input& in) {
  if (in.seen.empty())
    throw ArgumentError("no views to solve poses for", "take at least one picture of the markers");
  if (in.markers.size() < 4)
    throw ArgumentError("a pose needs 4 markers, not " + std::to_string(in.markers.size()),
                        "give the positions of all marker LEDs");
  Eigen::Matrix3Xd spread(3, static_cast<Eigen::Index>(in.markers.size()));
  for (std::size_t i = 0; i < in.markers.size(); ++i)
    spread.col(static_cast<Eigen::Index>(i)) = in.markers[i];
  spread.colwise() -= spread.rowwise().mean().eval();
  const Eigen::Vector3d s = Eigen::JacobiSVD<Eigen::Matrix3Xd>(spread).singularValues();
  if (!(s[1] > 1e-3 * s[0]))
    throw ArgumentError("the markers lie on one line", "check the marker positions");
  for (std::size_t v = 0; v < in.seen.size(); ++v)
    if (in.seen[v].size() != in.markers.size())
      throw ArgumentError(view_name(v) + ": " + std::to_string(in.seen[v].size()) + " points for " +
                              std::to_string(in.markers.size()) + " markers",
                          "give one image point per marker, in the markers' order");
}

bool coplanar(std::span<const Eigen::Vector3d> points) {
  Eigen::Matrix3Xd m(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) m.col(static_cast<Eigen::Index>(i)) = points[i];
  m.colwise() -= m.rowwise().mean().eval();
  const Eigen::Vector3d s = Eigen::JacobiSVD<Eigen::Matrix3Xd>(m).singularValues();
  return s[2] < 1e-6 * s[0];
}

RigidTransform start_pose(const Input& in, std::size_t v) {
  std::vector<cv::Point3d> object;
  std::vector<cv::Point2d> image;  // normalised, so the camera matrix is the identity
  for (std::size_t i = 0; i < in.markers.size(); ++i) {
    object.emplace_back(in.markers[i].x(), in.markers[i].y(), in.markers[i].z());
    const double y = (in.seen[v][i].y() - in.k.cy_px) / in.k.fy_px;
    const double x = (in.seen[v][i].x() - in.k.cx_px - in.k.skew_px * y) / in.k.fx_px;
    const Eigen::Vector2d u = undistort(in.d, {x, y});
    image.emplace_back(u.x(), u.y());
  }
  cv::Mat rvec, tvec;
  bool found = false;
  // IPPE can end in NaN when the markers are seen exactly head-on; the homography start does not.
  const bool flat = coplanar(in.markers);
  for (const auto method :
       {flat ? cv::SOLVEPNP_IPPE : cv::SOLVEPNP_SQPNP, cv::SOLVEPNP_ITERATIVE}) {
    if (method == cv::SOLVEPNP_ITERATIVE && !flat && in.markers.size() < 6) break;
    try {
      found = cv::solvePnP(object, image, cv::Matx33d::eye(), cv::noArray(), rvec, tvec, false,
                           method) &&
              cv::checkRange(rvec) && cv::checkRange(tvec);
    } catch (const cv::Exception&) {
      found = false;  // degenerate points; reported below in our words
    }
    if (found) break;
  }
  if (!found)
    throw ArgumentError(view_name(v) + ": no camera pose explains the marker positions",
                        "check the order of the markers and the camera's intrinsics");
  cv::Matx33d R;
  cv::Rodrigues(rvec, R);
  const RigidTransform T = {to_eigen(R),
                            {tvec.at<double>(0), tvec.at<double>(1), tvec.at<double>(2)}};
  for (const Eigen::Vector3d& p : in.markers)
    if (!((T * p).z() > 0))
      throw ArgumentError(view_name(v) + ": the markers come out behind the camera",
                          "check the order of the markers (mirrored image?)");
  return T;
}

Eigen::Matrix3d mean_rotation(const std::vector<RigidTransform>& poses) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const RigidTransform& T : poses) sum += T.R;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d D = Eigen::Matrix3d::Identity();
  D(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * D * svd.matrixV().transpose();
}

/// One bundle: refines all centres and one (shared) or all rotations. Fills poses, residuals and
/// RMS, and the covariances if wanted.
PoseSolution refine(const Input& in, const std::vector<RigidTransform>& starts, bool share,
                    const PoseOptions& options, bool want_covariance) {
  const std::size_t views = starts.size();
  const Eigen::Matrix3d R_mean = mean_rotation(starts);
  std::vector<std::array<double, 3>> turns(share ? 1 : views, {0, 0, 0}), centres(views);
  ceres::Problem problem;
  for (std::size_t v = 0; v < views; ++v) {
    Eigen::Map<Eigen::Vector3d>(centres[v].data()) = camera_centre(starts[v]);
    for (std::size_t i = 0; i < in.markers.size(); ++i)
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<Reprojection, 2, 3, 3>(new Reprojection{
              share ? R_mean : starts[v].R, in.markers[i], in.seen[v][i], in.k, in.d}),
          nullptr, turns[share ? 0 : v].data(), centres[v].data());
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.max_num_iterations = 100;
  solver.function_tolerance = solver.parameter_tolerance = 1e-14;
  solver.gradient_tolerance = 1e-12;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable())
    throw ArgumentError("the camera poses do not converge: " + summary.message,
                        "check the marker positions and the camera's intrinsics");

  PoseSolution out;
  double sum = 0;
  for (std::size_t v = 0; v < views; ++v) {
    Eigen::Matrix3d turn;
    ceres::AngleAxisToRotationMatrix(turns[share ? 0 : v].data(), turn.data());
    const Eigen::Matrix3d R = turn * (share ? R_mean : starts[v].R);
    out.T_camera_rsb.push_back({R, -(R * Eigen::Map<Eigen::Vector3d>(centres[v].data()))});
    out.residuals_px.emplace_back();
    for (std::size_t i = 0; i < in.markers.size(); ++i) {
      out.residuals_px[v].push_back(project(in.k, in.d, out.T_camera_rsb[v] * in.markers[i]) -
                                    in.seen[v][i]);
      sum += out.residuals_px[v].back().squaredNorm();
    }
  }
  const double points = static_cast<double>(views * in.markers.size());
  out.rms_px = std::sqrt(sum / points);
  if (!want_covariance) return out;

  const double freedom = 2 * points - 3 * static_cast<double>(views + turns.size());
  const double seen_sigma = freedom > 0 ? std::sqrt(sum / freedom) : 0;
  const double sigma = std::max(options.centroid_sigma_px, seen_sigma);
  ceres::Covariance::Options covariance_options;
  covariance_options.algorithm_type = ceres::DENSE_SVD;
  ceres::Covariance covariance(covariance_options);
  std::vector<std::pair<const double*, const double*>> blocks;
  for (const auto& c : centres) blocks.emplace_back(c.data(), c.data());
  if (!covariance.Compute(blocks, &problem))
    throw ArgumentError("the camera positions are not determined by the markers",
                        "check the marker positions");
  for (const auto& c : centres) {
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> block;
    covariance.GetCovarianceBlock(c.data(), c.data(), block.data());
    out.centre_covariance_mm2.push_back(sigma * sigma * block);
  }
  return out;
}

}  // namespace

PoseSolution solve_poses(std::span<const Eigen::Vector3d> markers_rsb,
                         std::span<const std::vector<Eigen::Vector2d>> seen_px_per_view,
                         const Intrinsics& k, const Distortion& d, const PoseOptions& options) {
  const Input in{markers_rsb, seen_px_per_view, k, d};
  check(in);
  std::vector<RigidTransform> starts;
  for (std::size_t v = 0; v < in.seen.size(); ++v) starts.push_back(start_pose(in, v));
  PoseSolution out = refine(in, starts, options.share_rotation, options, true);
  out.rms_free_px =
      options.share_rotation ? refine(in, starts, false, options, false).rms_px : out.rms_px;
  double worst_mm = 0;
  for (const Eigen::Matrix3d& c : out.centre_covariance_mm2)
    worst_mm = std::max(worst_mm, std::sqrt(c.trace()));
  char line[200];
  std::snprintf(line, sizeof line,
                "%zu poses, %s: RMS %.3f px (free rotations %.3f px), worst centre sigma %.3f mm",
                in.seen.size(), options.share_rotation ? "one rotation" : "a rotation each",
                out.rms_px, out.rms_free_px, worst_mm);
  out.report = line;
  return out;
}

}  // namespace wheatstone
