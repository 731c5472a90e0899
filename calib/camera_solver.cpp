#include "calib/camera_solver.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <optional>

#include "calib/camera_bundle.h"
#include "calib/pnp.h"
#include "core/error.h"

namespace wheatstone {
namespace {

using detail::CameraBlock;
using detail::CornerCost;
using detail::CornerResidual;
using detail::PoseBlock;

constexpr double kOutlierOfMedian = 3;
// Below this turn between the boards, focal length and board distance trade against each other.
constexpr double kMinTurn_rad = 3 * std::numbers::pi / 180;
constexpr double kOtherPose_rad = 0.1;
constexpr double kMaxRelativeFocalSigma = 0.05;
constexpr const char* kTiltRemedy =
    "add pictures with the board tilted by 30 to 45 degrees about both axes";

void check(std::span<const BoardView> views, const Board& board) {
  if (views.size() < 3)
    throw ArgumentError(
        "a camera calibration needs the board in 3 pictures, not " + std::to_string(views.size()),
        "take at least 10, with the board tilted and in all parts of the picture");
  for (const BoardView& v : views) seen_corners_mm(v, board);
}

/// Focal lengths to start from: Zhang's, and multiples of the width in case it has none.
std::vector<double> start_focal_lengths(std::span<const BoardView> views, const Board& board,
                                        int width_px, int height_px) {
  std::vector<std::vector<cv::Point3f>> object;
  std::vector<std::vector<cv::Point2f>> image;
  for (const BoardView& v : views) {
    object.emplace_back();
    image.emplace_back();
    for (const Eigen::Vector3d& p : seen_corners_mm(v, board))
      object.back().emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F);
    for (const Eigen::Vector2d& p : v.corners_px)
      image.back().emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  std::vector<double> starts;
  for (const double multiple : {0.35, 0.5, 0.7, 1.0, 1.5, 2.5, 5.0})
    starts.push_back(multiple * width_px);
  try {
    const double zhang =
        cv::initCameraMatrix2D(object, image, {width_px, height_px}, 1).at<double>(0, 0);
    if (zhang > 0.2 * width_px && zhang < 50 * width_px) starts.push_back(zhang);
  } catch (const cv::Exception&) {  // degenerate homographies: the multiples remain
  }
  return starts;
}

struct Start {
  Intrinsics k;
  Distortion d;
  std::vector<RigidTransform> poses;
  double squares = std::numeric_limits<double>::infinity();
};

/// The board poses under a camera and how well they fit; infinity when some board has none.
Start posed(std::span<const BoardView> views, const Board& board, const Intrinsics& k,
            const Distortion& d) {
  Start start{k, d, {}, 0};
  try {
    for (const BoardView& v : views) {
      const std::vector<Eigen::Vector3d> points = seen_corners_mm(v, board);
      start.poses.push_back(pose_from_points(points, v.corners_px, k, d, v.name));
      for (std::size_t i = 0; i < points.size(); ++i)
        start.squares +=
            (project(k, d, start.poses.back() * points[i]) - v.corners_px[i]).squaredNorm();
    }
  } catch (const ArgumentError&) {
    start.squares = std::numeric_limits<double>::infinity();
  }
  return start;
}

struct Bundle {
  CameraBlock camera;
  std::vector<PoseBlock> poses;
  std::vector<std::vector<const CornerCost*>> costs;  // [picture][corner], owned by `problem`
  ceres::Problem problem;
};

void build(Bundle& b, std::span<const BoardView> views, const Board& board, const Start& start) {
  b.camera = detail::camera_block(start.k, start.d);
  for (const RigidTransform& T : start.poses) b.poses.emplace_back(T);
  b.costs.resize(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    const std::vector<Eigen::Vector3d> points = seen_corners_mm(views[v], board);
    for (std::size_t i = 0; i < points.size(); ++i) {
      b.costs[v].push_back(new CornerCost(new CornerResidual{
          b.poses[v].R_start, points[i], views[v].corners_px[i], start.d.fisheye}));
      b.problem.AddResidualBlock(const_cast<CornerCost*>(b.costs[v].back()), nullptr,
                                 b.camera.data(), b.poses[v].turn_t.data());
    }
  }
}

Start refine(std::span<const BoardView> views, const Board& board, const Start& start,
             DistortionModel model) {
  Bundle b;
  build(b, views, board, start);
  if (auto* manifold = detail::camera_manifold(model))
    b.problem.SetManifold(b.camera.data(), manifold);
  detail::solve_to_end(
      b.problem, "the camera calibration",
      "check --board against the board in the pictures and " + std::string(kTiltRemedy));
  Start out = start;
  detail::set_camera(b.camera, out.k, out.d);
  for (std::size_t v = 0; v < views.size(); ++v) out.poses[v] = b.poses[v].transform();
  b.problem.Evaluate({}, &out.squares, nullptr, nullptr, nullptr);
  out.squares *= 2;
  return out;
}

double largest_turn_rad(const std::vector<RigidTransform>& poses) {
  double smallest_cosine = 1;
  for (const RigidTransform& a : poses)
    for (const RigidTransform& b : poses)
      smallest_cosine = std::min(smallest_cosine, a.R.col(2).dot(b.R.col(2)));
  return std::acos(std::clamp(smallest_cosine, -1.0, 1.0));
}

/// True if some board is turned between the two by more than a start's inaccuracy.
bool turned(const std::vector<RigidTransform>& a, const std::vector<RigidTransform>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t v = 0; v < a.size(); ++v)
    if (Eigen::AngleAxisd(a[v].R.transpose() * b[v].R).angle() > kOtherPose_rad) return true;
  return false;
}

/// Covariance, residuals and their sizes at the optimum.
CameraCalibration conclude(std::span<const BoardView> views, const Board& board,
                           const Start& optimum, DistortionModel model) {
  Bundle b;
  build(b, views, board, optimum);
  const std::vector<int> free = detail::free_parameters(model);
  detail::SharedInformation information;
  CameraCalibration out;
  out.intrinsics = optimum.k;
  out.distortion = optimum.d;
  out.model = model;
  out.T_camera_board = optimum.poses;
  double all = 0;
  std::size_t corners = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const std::size_t seen = views[v].corners_px.size();
    const auto rows = static_cast<Eigen::Index>(2 * seen);
    Eigen::MatrixXd J_camera(rows, static_cast<Eigen::Index>(free.size())), J_board(rows, 6);
    Eigen::VectorXd residuals(rows);
    out.residuals_px.emplace_back();
    for (std::size_t i = 0; i < seen; ++i) {
      Eigen::Matrix<double, 2, 12, Eigen::RowMajor> J12;
      Eigen::Matrix<double, 2, 6, Eigen::RowMajor> J6;
      Eigen::Vector2d r;
      const double* parameters[] = {b.camera.data(), b.poses[v].turn_t.data()};
      double* jacobians[] = {J12.data(), J6.data()};
      b.costs[v][i]->Evaluate(parameters, r.data(), jacobians);
      const auto row = static_cast<Eigen::Index>(2 * i);
      J_camera.middleRows<2>(row) = J12(Eigen::all, free);
      J_board.middleRows<2>(row) = J6;
      residuals.segment<2>(row) = r;
      out.residuals_px.back().push_back(r);
    }
    information.add_board(J_camera, J_board, residuals);
    out.board_rms_px.push_back(std::sqrt(residuals.squaredNorm() / static_cast<double>(seen)));
    all += residuals.squaredNorm();
    corners += seen;
  }
  out.rms_px = std::sqrt(all / static_cast<double>(corners));
  out.corner_sigma_px = information.corner_sigma_px();
  out.covariance = information.covariance();
  return out;
}

void require_determined(const CameraCalibration& c) {
  char turn[80];
  std::snprintf(turn, sizeof turn, "they turn against each other by at most %.1f degrees",
                largest_turn_rad(c.T_camera_board) * 180 / std::numbers::pi);
  const bool determined =
      c.covariance.size() > 0 && largest_turn_rad(c.T_camera_board) > kMinTurn_rad &&
      std::sqrt(c.covariance(0, 0)) < kMaxRelativeFocalSigma * c.intrinsics.fx_px;
  if (!determined)
    throw ArgumentError("the focal length is not determined by these boards: " + std::string(turn),
                        kTiltRemedy);
}

}  // namespace

std::vector<Eigen::Vector3d> seen_corners_mm(const BoardView& view, const Board& board) {
  const std::vector<Eigen::Vector3d> all = corners_mm(board);
  const std::size_t expected = view.corner_ids.empty() ? all.size() : view.corner_ids.size();
  if (view.corners_px.size() != expected || expected < kMinCorners)
    throw ArgumentError(view.name + ": " + std::to_string(view.corners_px.size()) +
                            " corners for " + std::to_string(expected) + " of the board",
                        "find the board again with the right --board; " +
                            std::to_string(kMinCorners) + " corners are needed");
  if (view.corner_ids.empty()) return all;
  std::vector<Eigen::Vector3d> seen;
  for (const int id : view.corner_ids) {
    if (id < 0 || static_cast<std::size_t>(id) >= all.size())
      throw ArgumentError(view.name + ": corner " + std::to_string(id) + " is not on the board",
                          "find the board again with its own size");
    seen.push_back(all[static_cast<std::size_t>(id)]);
  }
  return seen;
}

std::string to_string(DistortionModel model) {
  switch (model) {
    case DistortionModel::kRadtan4:
      return "radtan4";
    case DistortionModel::kRadtan5:
      return "radtan5";
    case DistortionModel::kRadtan8:
      return "radtan8";
    case DistortionModel::kFisheye:
      return "fisheye";
  }
  throw InternalError("no such distortion model");
}

DistortionModel distortion_model_from_string(const std::string& name) {
  for (const auto model : {DistortionModel::kRadtan4, DistortionModel::kRadtan5,
                           DistortionModel::kRadtan8, DistortionModel::kFisheye})
    if (name == to_string(model)) return model;
  throw ArgumentError("'" + name + "' is no distortion model",
                      "use radtan4, radtan5, radtan8 or fisheye");
}

std::vector<std::string> coefficient_names(DistortionModel model) {
  static constexpr const char* kNames[] = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  std::vector<std::string> names;
  for (const int i : detail::free_parameters(model))
    if (i >= 4) names.emplace_back(kNames[i - 4]);
  return names;
}

std::vector<double> coefficients(const Distortion& d, DistortionModel model) {
  std::vector<double> values;
  for (const int i : detail::free_parameters(model))
    if (i >= 4) values.push_back(d.coefficients()[static_cast<std::size_t>(i - 4)]);
  return values;
}

CameraCalibration solve_camera(std::span<const BoardView> views, const Board& board, int width_px,
                               int height_px, DistortionModel model) {
  check(views, board);
  Distortion lens;
  lens.fisheye = model == DistortionModel::kFisheye;
  Start best;
  for (const double f : start_focal_lengths(views, board, width_px, height_px)) {
    const Start start =
        posed(views, board,
              {f, f, 0, (width_px - 1) / 2.0, (height_px - 1) / 2.0, width_px, height_px}, lens);
    if (start.squares < best.squares) best = start;
  }
  if (best.poses.empty())
    throw ArgumentError("no camera explains the boards",
                        "check --board against the board in the pictures");
  best = refine(views, board, best, model);
  // A plane seen from afar has two poses that differ little; under a rough camera the wrong one
  // may have won, and a descent does not cross over to the other.
  const Start again = posed(views, board, best.k, best.d);
  if (!again.poses.empty() && turned(again.poses, best.poses)) {
    const Start refined = refine(views, board, again, model);
    if (refined.squares < best.squares) best = refined;
  }
  CameraCalibration out = conclude(views, board, best, model);
  require_determined(out);
  return out;
}

RigidTransform solve_board_pose(const BoardView& view, const Board& board, const Intrinsics& k,
                                const Distortion& d) {
  const std::span<const BoardView> views(&view, 1);
  const Start start{
      k, d, {pose_from_points(seen_corners_mm(view, board), view.corners_px, k, d, view.name)}, 0};
  Bundle b;
  build(b, views, board, start);
  b.problem.SetParameterBlockConstant(b.camera.data());
  detail::solve_to_end(b.problem, view.name + ": the board's pose", "check --board");
  return b.poses[0].transform();
}

std::vector<double> cross_validate(std::span<const BoardView> views, const Board& board,
                                   int width_px, int height_px, DistortionModel model, int folds) {
  std::vector<double> rms(views.size());
  const auto parts = static_cast<std::size_t>(folds);
  for (std::size_t part = 0; part < std::min(parts, views.size()); ++part) {
    std::vector<BoardView> kept;
    for (std::size_t v = 0; v < views.size(); ++v)
      if (v % parts != part) kept.push_back(views[v]);
    const CameraCalibration c = solve_camera(kept, board, width_px, height_px, model);
    for (std::size_t v = part; v < views.size(); v += parts) {
      const RigidTransform T = solve_board_pose(views[v], board, c.intrinsics, c.distortion);
      const std::vector<Eigen::Vector3d> points = seen_corners_mm(views[v], board);
      double squares = 0;
      for (std::size_t i = 0; i < points.size(); ++i)
        squares += (project(c.intrinsics, c.distortion, T * points[i]) - views[v].corners_px[i])
                       .squaredNorm();
      rms[v] = std::sqrt(squares / static_cast<double>(points.size()));
    }
  }
  return rms;
}

std::vector<std::size_t> outlier_boards(const CameraCalibration& c) {
  std::vector<double> sorted = c.board_rms_px;
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::size_t> outliers;
  for (std::size_t v = 0; v < c.board_rms_px.size(); ++v)
    if (c.board_rms_px[v] > kOutlierOfMedian * sorted[sorted.size() / 2]) outliers.push_back(v);
  return outliers;
}

}  // namespace wheatstone
