#include "calib/stereo_solver.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/camera_bundle.h"
#include "core/error.h"

namespace wheatstone {
namespace {

using detail::PoseBlock;

/// One corner seen by the right camera. Residual: 2, predicted - seen, px.
struct RightResidual {
  Eigen::Matrix3d R_left_start, R_right_left_start;
  Eigen::Vector3d p_board;
  Eigen::Vector2d seen_px;
  bool fisheye;

  template <class T>
  bool operator()(const T* camera, const T* T_right_left, const T* T_left_board,
                  T* residual_px) const {
    const Eigen::Matrix<T, 3, 1> p_left =
        detail::apply<T>(R_left_start, T_left_board, p_board.cast<T>());
    const Eigen::Matrix<T, 3, 1> p_right =
        detail::apply<T>(R_right_left_start, T_right_left, p_left);
    if (!detail::project_px(camera, fisheye, p_right, residual_px)) return false;
    residual_px[0] -= seen_px.x();
    residual_px[1] -= seen_px.y();
    return true;
  }
};
using RightCost = ceres::AutoDiffCostFunction<RightResidual, 2, 12, 6, 6>;

/// The board's frame after half a turn: its last corner becomes the first.
RigidTransform half_turn(const Board& board) {
  return {Eigen::Vector3d(-1, -1, 1).asDiagonal(),
          {(board.columns - 1) * board.square_mm, (board.rows - 1) * board.square_mm, 0}};
}

double difference(const RigidTransform& a, const RigidTransform& b, double depth_mm) {
  return Eigen::AngleAxisd(a.R.transpose() * b.R).angle() + (a.t_mm - b.t_mm).norm() / depth_mm;
}

/// T_right_left that most pairs agree on, and whether each right board starts at the other end.
struct Agreement {
  RigidTransform T_right_left;
  std::vector<bool> turned;
};

Agreement agree(const CameraCalibration& left, const CameraCalibration& right, const Board& board) {
  const std::size_t pairs = left.T_camera_board.size();
  std::vector<std::array<RigidTransform, 2>> candidates;  // as found, and turned
  double depth_mm = 0;
  for (std::size_t i = 0; i < pairs; ++i) {
    const RigidTransform T_board_left = left.T_camera_board[i].inverse();
    candidates.push_back({right.T_camera_board[i] * T_board_left,
                          right.T_camera_board[i] * half_turn(board) * T_board_left});
    depth_mm += left.T_camera_board[i].t_mm.norm() / static_cast<double>(pairs);
  }
  Agreement best;
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& pair : candidates)
    for (const RigidTransform& T : pair) {
      double sum = 0;
      std::vector<bool> turned;
      for (const auto& other : candidates) {
        const double found = difference(T, other[0], depth_mm);
        const double reversed = difference(T, other[1], depth_mm);
        turned.push_back(reversed < found);
        sum += std::min(found, reversed);
      }
      // Half a turn of everything fits as well, with the right camera upside down.
      sum += 1e-3 * Eigen::AngleAxisd(T.R).angle();
      if (sum < smallest) {
        smallest = sum;
        best = {T, turned};
      }
    }
  return best;
}

double rms(const std::vector<Eigen::Vector2d>& residuals) {
  double squares = 0;
  for (const Eigen::Vector2d& r : residuals) squares += r.squaredNorm();
  return std::sqrt(squares / static_cast<double>(residuals.size()));
}

}  // namespace

StereoCalibration solve_stereo(std::span<const BoardView> left, std::span<const BoardView> right,
                               const Board& board, int width_px, int height_px,
                               DistortionModel model) {
  if (left.size() != right.size())
    throw ArgumentError("there are " + std::to_string(left.size()) + " left and " +
                            std::to_string(right.size()) + " right pictures of the boards",
                        "give pairs that show the same board at the same moment");
  for (const auto& views : {left, right})
    for (const BoardView& v : views)
      if (!v.corner_ids.empty())
        throw ArgumentError(v.name + ": a stereo calibration needs the whole board",
                            "find a chessboard's corners in both pictures");
  StereoCalibration out;
  out.left = solve_camera(left, board, width_px, height_px, model);
  out.right = solve_camera(right, board, width_px, height_px, model);
  const Agreement start = agree(out.left, out.right, board);

  const std::vector<Eigen::Vector3d> points = corners_mm(board);
  const bool fisheye = model == DistortionModel::kFisheye;
  auto left_camera = detail::camera_block(out.left.intrinsics, out.left.distortion);
  auto right_camera = detail::camera_block(out.right.intrinsics, out.right.distortion);
  PoseBlock between(start.T_right_left);
  std::vector<PoseBlock> boards;
  for (const RigidTransform& T : out.left.T_camera_board) boards.emplace_back(T);

  struct CornerPair {
    detail::CornerCost* left;
    RightCost* right;
  };
  std::vector<std::vector<CornerPair>> costs(left.size());  // owned by the problem
  ceres::Problem problem;
  for (std::size_t v = 0; v < left.size(); ++v)
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto& seen_right = right[v].corners_px[start.turned[v] ? points.size() - 1 - i : i];
      costs[v].push_back({new detail::CornerCost(new detail::CornerResidual{
                              boards[v].R_start, points[i], left[v].corners_px[i], fisheye}),
                          new RightCost(new RightResidual{boards[v].R_start, between.R_start,
                                                          points[i], seen_right, fisheye})});
      problem.AddResidualBlock(costs[v].back().left, nullptr, left_camera.data(),
                               boards[v].turn_t.data());
      problem.AddResidualBlock(costs[v].back().right, nullptr, right_camera.data(),
                               between.turn_t.data(), boards[v].turn_t.data());
    }
  for (double* camera : {left_camera.data(), right_camera.data()})
    if (auto* manifold = detail::camera_manifold(model)) problem.SetManifold(camera, manifold);
  detail::solve_to_end(problem, "the stereo calibration",
                       "check that left and right pictures with one number belong together");

  // Shared parameters: left camera, right camera, turn and translation between them.
  const std::vector<int> free = detail::free_parameters(model);
  const auto n = static_cast<Eigen::Index>(free.size());
  detail::SharedInformation information;
  detail::set_camera(left_camera, out.left.intrinsics, out.left.distortion);
  detail::set_camera(right_camera, out.right.intrinsics, out.right.distortion);
  out.T_right_left = between.transform();
  double squares = 0;
  for (std::size_t v = 0; v < left.size(); ++v) {
    const auto rows = static_cast<Eigen::Index>(2 * points.size());  // of each picture
    Eigen::MatrixXd J_shared = Eigen::MatrixXd::Zero(2 * rows, 2 * n + 6), J_board(2 * rows, 6);
    Eigen::VectorXd residuals(2 * rows);
    for (std::size_t i = 0; i < points.size(); ++i) {
      Eigen::Matrix<double, 2, 12, Eigen::RowMajor> J_left, J_right;
      Eigen::Matrix<double, 2, 6, Eigen::RowMajor> J_between, J_pose_left, J_pose_right;
      const auto row = static_cast<Eigen::Index>(2 * i);
      Eigen::Vector2d r_left, r_right;
      const double* of_left[] = {left_camera.data(), boards[v].turn_t.data()};
      double* left_jacobians[] = {J_left.data(), J_pose_left.data()};
      costs[v][i].left->Evaluate(of_left, r_left.data(), left_jacobians);
      const double* of_right[] = {right_camera.data(), between.turn_t.data(),
                                  boards[v].turn_t.data()};
      double* right_jacobians[] = {J_right.data(), J_between.data(), J_pose_right.data()};
      costs[v][i].right->Evaluate(of_right, r_right.data(), right_jacobians);
      J_shared.block(row, 0, 2, n) = J_left(Eigen::all, free);
      J_shared.block(rows + row, n, 2, n) = J_right(Eigen::all, free);
      J_shared.block<2, 6>(rows + row, 2 * n) = J_between;
      J_board.middleRows<2>(row) = J_pose_left;
      J_board.middleRows<2>(rows + row) = J_pose_right;
      residuals.segment<2>(row) = out.left.residuals_px[v][i] = r_left;
      residuals.segment<2>(rows + row) = out.right.residuals_px[v][i] = r_right;
    }
    information.add_board(J_shared, J_board, residuals, 2);
    squares += residuals.squaredNorm();
    out.left.T_camera_board[v] = boards[v].transform();
    out.right.T_camera_board[v] = out.T_right_left * out.left.T_camera_board[v];
    out.left.board_rms_px[v] = rms(out.left.residuals_px[v]);
    out.right.board_rms_px[v] = rms(out.right.residuals_px[v]);
  }
  const Eigen::MatrixXd covariance = information.covariance();
  if (covariance.size() == 0)
    throw ArgumentError("the boards do not determine the two cameras",
                        "add pictures with the board tilted and nearer");
  out.left.covariance = covariance.topLeftCorner(n, n);
  out.right.covariance = covariance.block(n, n, n, n);
  // The solver's turn stands before the start rotation; at the optimum it is small or 0, and
  // turning further about the camera's axes adds to it to first order.
  out.T_right_left_covariance = covariance.bottomRightCorner<6, 6>();
  for (CameraCalibration* c : {&out.left, &out.right}) {
    double own = 0;
    for (const double r : c->board_rms_px) own += r * r;
    c->rms_px = std::sqrt(own / static_cast<double>(left.size()));
    c->corner_sigma_px = information.corner_sigma_px();
  }
  out.rms_px = std::sqrt(squares / static_cast<double>(2 * left.size() * points.size()));
  out.baseline_mm = out.T_right_left.t_mm.norm();
  const Eigen::Vector3d along = out.T_right_left.t_mm / out.baseline_mm;
  out.baseline_sigma_mm =
      std::sqrt(along.dot(out.T_right_left_covariance.bottomRightCorner<3, 3>() * along));
  return out;
}

}  // namespace wheatstone
