#include "calib/pose_solver.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "calib/pnp.h"
#include "core/error.h"

namespace wheatstone {
namespace {

constexpr double kTrustedFreedom = 8;  // with fewer, the residuals' scatter says little

/// The pixel of p_camera = exp(turn) R_start (p - centre): the turn stays small, away from the
/// angle-axis singularity that "straight into the box" (half a turn about x) sits on.
template <class T>
bool project_marker(const Eigen::Matrix3d& R_start, const Eigen::Vector3d& p_rsb,
                    const Intrinsics& k, const Distortion& d, const T* turn, const T* centre,
                    T* px) {
  const Eigen::Matrix<T, 3, 1> offset(T(p_rsb.x()) - centre[0], T(p_rsb.y()) - centre[1],
                                      T(p_rsb.z()) - centre[2]);
  const Eigen::Matrix<T, 3, 1> start = R_start.cast<T>() * offset;
  T p[3];
  ceres::AngleAxisRotatePoint(turn, start.data(), p);
  if (!(p[2] > T(0))) return false;
  const auto c = d.coefficients();
  const Eigen::Matrix<T, 2, 1> xy = distort(c.data(), d.fisheye, T(p[0] / p[2]), T(p[1] / p[2]));
  px[0] = k.fx_px * xy[0] + k.skew_px * xy[1] + k.cx_px;
  px[1] = k.fy_px * xy[1] + k.cy_px;
  return true;
}

/// One marker in one view. Residual: 2, predicted - seen in units of its standard deviation.
struct Reprojection {
  Eigen::Matrix3d R_start;
  Eigen::Vector3d p_rsb;
  Eigen::Vector2d seen_px;
  Eigen::Matrix2d whitening;  // 1/px: W^T W is the inverse of the sighting's covariance
  Intrinsics k;
  Distortion d;

  template <class T>
  bool operator()(const T* turn, const T* centre, T* residual) const {
    T px[2];
    if (!project_marker(R_start, p_rsb, k, d, turn, centre, px)) return false;
    const T dx = px[0] - seen_px.x(), dy = px[1] - seen_px.y();
    residual[0] = whitening(0, 0) * dx + whitening(0, 1) * dy;
    residual[1] = whitening(1, 0) * dx + whitening(1, 1) * dy;
    return true;
  }
};

/// Distance of a centre from the line through the two outermost ones. Residual: 3 (of rank 2), in
/// units of the rail's straightness.
struct OffTheRail {
  double straightness_mm;

  template <class T>
  bool operator()(const T* first, const T* last, const T* centre, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Vector> a(first), b(last), c(centre);
    const Vector along = b - a, offset = c - a;
    const T share = along.dot(offset) / along.squaredNorm();
    Eigen::Map<Vector> out(residual);
    out = (offset - share * along) / T(straightness_mm);
    return true;
  }
};

struct Input {
  std::span<const Eigen::Vector3d> markers;
  std::span<const std::vector<MarkerSighting>> seen;
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
  for (std::size_t v = 0; v < in.seen.size(); ++v)
    for (const MarkerSighting& m : in.seen[v])
      if (!m.px.allFinite() || !(m.covariance_px2.determinant() > 0) ||
          !(m.covariance_px2.trace() > 0))
        throw ArgumentError(view_name(v) + ": a marker has no position or no covariance",
                            "find the markers again");
}

Eigen::Matrix3d mean_rotation(const std::vector<RigidTransform>& poses) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const RigidTransform& T : poses) sum += T.R;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d D = Eigen::Matrix3d::Identity();
  D(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * D * svd.matrixV().transpose();
}

/// One bundle: all centres and one (shared) or all rotations.
class Bundle {
 public:
  Bundle(const Input& in, const std::vector<RigidTransform>& starts, bool share,
         double noise_factor)
      : in_(in), share_(share), centres_(starts.size()) {
    const Eigen::Matrix3d R_mean = mean_rotation(starts);
    for (const RigidTransform& T : starts) {
      const std::size_t v = R_start_.size();
      R_start_.push_back(share ? R_mean : T.R);
      if (!share || v == 0) turns_.push_back({0, 0, 0});
      Eigen::Map<Eigen::Vector3d>(centres_[v].data()) = camera_centre(T);
    }
    for (std::size_t v = 0; v < starts.size(); ++v)
      for (std::size_t i = 0; i < in.markers.size(); ++i) {
        const MarkerSighting& m = in.seen[v][i];
        const Eigen::Matrix2d L = m.covariance_px2.llt().matrixL();
        problem_.AddResidualBlock(
            new ceres::AutoDiffCostFunction<Reprojection, 2, 3, 3>(new Reprojection{
                R_start_[v], in.markers[i], m.px, L.inverse() / noise_factor, in.k, in.d}),
            nullptr, turn(v), centres_[v].data());
      }
  }

  void add_straight_rail(double straightness_mm) {
    // The two outermost centres, which stay so.
    std::size_t first = 0, last = 0;
    double longest = 0;
    for (std::size_t a = 0; a < centres_.size(); ++a)
      for (std::size_t b = a + 1; b < centres_.size(); ++b)
        if (const double length = (centre(a) - centre(b)).norm(); length > longest)
          longest = length, first = a, last = b;
    for (std::size_t v = 0; v < centres_.size(); ++v)
      if (longest > 0 && v != first && v != last)
        problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<OffTheRail, 3, 3, 3, 3>(
                                      new OffTheRail{straightness_mm}),
                                  nullptr, centres_[first].data(), centres_[last].data(),
                                  centres_[v].data());
  }

  void solve() {
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::DENSE_QR;
    solver.max_num_iterations = 100;
    solver.function_tolerance = solver.parameter_tolerance = 1e-14;
    solver.gradient_tolerance = 1e-12;
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem_, &summary);
    if (!summary.IsSolutionUsable())
      throw ArgumentError("the camera poses do not converge: " + summary.message,
                          "check the marker positions and the camera's intrinsics");
  }

  RigidTransform pose(std::size_t v) const {
    Eigen::Matrix3d turn_matrix;
    ceres::AngleAxisToRotationMatrix(turns_[share_ ? 0 : v].data(), turn_matrix.data());
    const Eigen::Matrix3d R = turn_matrix * R_start_[v];
    return {R, -(R * centre(v))};
  }
  Eigen::Vector3d centre(std::size_t v) const {
    return Eigen::Map<const Eigen::Vector3d>(centres_[v].data());
  }

  /// Sum of squares of the markers' residuals in their units, and its degrees of freedom.
  double squares() {
    double cost = 0;
    problem_.Evaluate({}, &cost, nullptr, nullptr, nullptr);
    return 2 * cost;
  }
  double freedom() const {
    return static_cast<double>(2 * centres_.size() * in_.markers.size()) -
           3 * static_cast<double>(centres_.size() + turns_.size());
  }

  std::vector<Eigen::Matrix<double, 6, 6>> covariance() {
    ceres::Covariance::Options options;
    options.algorithm_type = ceres::DENSE_SVD;
    ceres::Covariance covariance(options);
    std::vector<std::vector<const double*>> views;
    std::vector<std::pair<const double*, const double*>> blocks;
    for (std::size_t v = 0; v < centres_.size(); ++v) {
      views.push_back({turn(v), centres_[v].data()});
      blocks.emplace_back(turn(v), centres_[v].data());
      blocks.emplace_back(centres_[v].data(), centres_[v].data());
      if (!share_ || v == 0) blocks.emplace_back(turn(v), turn(v));
    }
    if (!covariance.Compute(blocks, &problem_))
      throw ArgumentError("the camera positions are not determined by the markers",
                          "check the marker positions");
    std::vector<Eigen::Matrix<double, 6, 6>> out;
    for (const auto& view : views) {
      Eigen::Matrix<double, 6, 6, Eigen::RowMajor> block;
      covariance.GetCovarianceMatrix(view, block.data());
      out.emplace_back(block);
    }
    return out;
  }

 private:
  double* turn(std::size_t v) { return turns_[share_ ? 0 : v].data(); }

  const Input& in_;
  bool share_;
  std::vector<Eigen::Matrix3d> R_start_;
  std::vector<std::array<double, 3>> turns_, centres_;
  ceres::Problem problem_;
};

double rms(const std::vector<std::vector<Eigen::Vector2d>>& residuals) {
  double squares = 0, count = 0;
  for (const auto& view : residuals)
    for (const Eigen::Vector2d& r : view) squares += r.squaredNorm(), ++count;
  return std::sqrt(squares / count);
}

std::vector<std::vector<Eigen::Vector2d>> residuals(const Input& in, const Bundle& bundle) {
  std::vector<std::vector<Eigen::Vector2d>> all(in.seen.size());
  for (std::size_t v = 0; v < in.seen.size(); ++v)
    for (std::size_t i = 0; i < in.markers.size(); ++i)
      all[v].push_back(project(in.k, in.d, bundle.pose(v) * in.markers[i]) - in.seen[v][i].px);
  return all;
}

/// Standard deviation of a residual per axis, from the residuals per degree of freedom.
double scatter(const Input& in, const Bundle& bundle) {
  double squares = 0;
  for (const auto& view : residuals(in, bundle))
    for (const Eigen::Vector2d& r : view) squares += r.squaredNorm();
  return std::sqrt(squares / std::max(bundle.freedom(), 1.0));
}

}  // namespace

PoseSolution solve_poses(std::span<const Eigen::Vector3d> markers_rsb,
                         std::span<const std::vector<MarkerSighting>> seen_per_view,
                         const Intrinsics& k, const Distortion& d, const PoseOptions& options) {
  const Input in{markers_rsb, seen_per_view, k, d};
  check(in);
  if (!(options.rail_straightness_mm > 0))
    throw ArgumentError("the rail's straightness must be above 0 mm",
                        "give its standard deviation");
  std::vector<RigidTransform> starts;
  for (std::size_t v = 0; v < in.seen.size(); ++v) {
    std::vector<Eigen::Vector2d> px;
    for (const MarkerSighting& m : in.seen[v]) px.push_back(m.px);
    starts.push_back(pose_from_points(in.markers, px, k, d, view_name(v)));
  }

  // Without the straightness prior first: its residuals tell how large the sightings' errors are,
  // and its centres how straight the rail is.
  Bundle loose(in, starts, options.straight_rail, 1);
  loose.solve();
  // Of a plane's two poses the wrong one may start a view and put its centre beyond the outermost.
  for (std::size_t v = 0; v < starts.size(); ++v) starts[v] = loose.pose(v);
  PoseSolution out;
  // Few residuals leave their own size in doubt: Student's t with n degrees of freedom has the
  // variance n / (n - 2), which makes 1.96 standard deviations hold 95 % from n = 8 on.
  const double n = loose.freedom();
  out.noise_factor = n >= kTrustedFreedom
                         ? std::sqrt(loose.squares() / (n - 2))
                         : std::max(1.0, std::sqrt(loose.squares() / std::max(n, 1.0)));
  // Noise-free sightings leave no residuals; the covariance is then 0 to rounding.
  out.noise_factor = std::max(out.noise_factor, 1e-6);
  Bundle bundle(in, starts, options.straight_rail, out.noise_factor);
  if (options.straight_rail) bundle.add_straight_rail(options.rail_straightness_mm);
  bundle.solve();
  out.covariance = bundle.covariance();
  out.residuals_px = residuals(in, bundle);
  for (std::size_t v = 0; v < in.seen.size(); ++v) {
    out.T_camera_rsb.push_back(bundle.pose(v));
    out.free_centres_rsb.push_back(loose.centre(v));
    out.view_rms_px.push_back(rms({out.residuals_px[v]}));
  }
  out.rms_px = out.rms_free_px = rms(out.residuals_px);
  out.scatter_px = out.scatter_free_px = scatter(in, loose);
  if (options.straight_rail) {
    Bundle free(in, starts, false, 1);
    free.solve();
    out.rms_free_px = rms(residuals(in, free));
    out.scatter_free_px = scatter(in, free);
  }

  double worst_mm = 0;
  for (std::size_t v = 0; v < in.seen.size(); ++v)
    worst_mm = std::max(worst_mm, std::sqrt(out.centre_covariance_mm2(v).trace()));
  char line[300];
  std::snprintf(line, sizeof line,
                "%zu %s, %s: RMS %.3f px, per degree of freedom %.3f px (%.3f px with a rotation "
                "each), noise factor %.2f, worst centre sigma %.3f mm",
                in.seen.size(), in.seen.size() == 1 ? "pose" : "poses",
                options.straight_rail ? "one rotation" : "a rotation each", out.rms_px,
                out.scatter_px, out.scatter_free_px, out.noise_factor, worst_mm);
  out.report = line;
  return out;
}

double plane_uncertainty_px(const RigidTransform& T, const Eigen::Matrix<double, 6, 6>& covariance,
                            const Intrinsics& k, const Distortion& d, double plane_z_mm,
                            const Eigen::Vector2d& min_mm, const Eigen::Vector2d& max_mm) {
  using Jet = ceres::Jet<double, 6>;
  constexpr int kSide = 5;
  const Eigen::Vector3d c = camera_centre(T);
  Jet turn[3], centre[3];
  for (int i = 0; i < 3; ++i) {
    turn[i] = Jet(0, i);
    centre[i] = Jet(c[i], 3 + i);
  }
  double sum = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Eigen::Vector2d share(i % kSide / (kSide - 1.0), i / kSide / (kSide - 1.0));
    const Eigen::Vector2d xy = min_mm + share.cwiseProduct(max_mm - min_mm);
    Jet px[2];
    if (!project_marker(T.R, {xy.x(), xy.y(), plane_z_mm}, k, d, turn, centre, px))
      throw ArgumentError("the plane is not in front of the camera", "check the poses' frame");
    for (const Jet& value : px) sum += value.v.dot(covariance * value.v);
  }
  return std::sqrt(sum / (kSide * kSide));
}

}  // namespace wheatstone
