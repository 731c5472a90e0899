#include "calib/camera_uncertainty.h"

#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <optional>

#include "calib/camera_bundle.h"
#include "core/error.h"

namespace wheatstone {
namespace {

constexpr int kColumns = 33;     // nodes of the grid over the picture
constexpr double kMarginPx = 5;  // a board nearer to the edge may not be found
constexpr double kTilt_rad = 40 * std::numbers::pi / 180;

using Jacobian = Eigen::Matrix<double, 2, Eigen::Dynamic>;

/// Derivatives of the pixel of a point in the camera frame by the free intrinsics, and by a turn
/// (rad) and a shift (in the point's unit) of what it belongs to.
struct PointJacobian {
  Jacobian by_intrinsics;
  Eigen::Matrix<double, 2, 6> by_pose;
};

PointJacobian point_jacobian(const CameraCalibration& c, const Eigen::Vector3d& p) {
  using Jet = ceres::Jet<double, 18>;
  const detail::CameraBlock block = detail::camera_block(c.intrinsics, c.distortion);
  std::array<Jet, 12> camera;
  std::array<Jet, 6> pose;
  for (int i = 0; i < 12; ++i) camera[i] = Jet(block[i], i);
  for (int i = 0; i < 6; ++i) pose[i] = Jet(0, 12 + i);
  const Eigen::Matrix<Jet, 3, 1> moved = detail::apply<Jet>(
      Eigen::Matrix3d::Identity(), pose.data(), {Jet(p.x()), Jet(p.y()), Jet(p.z())});
  Jet px[2];
  detail::project_px(camera.data(), c.distortion.fisheye, moved, px);
  const std::vector<int> free = detail::free_parameters(c.model);
  PointJacobian J;
  J.by_intrinsics.resize(2, static_cast<Eigen::Index>(free.size()));
  for (int r = 0; r < 2; ++r) {
    J.by_intrinsics.row(r) = px[r].v(free).transpose();
    J.by_pose.row(r) = px[r].v.tail<6>().transpose();
  }
  return J;
}

/// A grid of pixels over the picture, ends included, with what a change of the intrinsics does
/// there once the best turn is taken out; empty where there is no ray.
class PictureGrid {
 public:
  explicit PictureGrid(const CameraCalibration& c)
      : rows_(std::max(2, (kColumns * c.intrinsics.height_px + c.intrinsics.width_px / 2) /
                              c.intrinsics.width_px)) {
    const Intrinsics& k = c.intrinsics;
    std::vector<std::optional<PointJacobian>> rays;
    const auto n = c.covariance.rows();
    Eigen::Matrix3d turn_turn = Eigen::Matrix3d::Zero();
    Eigen::MatrixXd turn_intrinsics = Eigen::MatrixXd::Zero(3, n);
    for (int r = 0; r < rows_; ++r)
      for (int column = 0; column < kColumns; ++column) {
        const double x = column * (k.width_px - 1.0) / (kColumns - 1);
        const double y = r * (k.height_px - 1.0) / (rows_ - 1);
        try {
          const Eigen::Vector2d xy =
              undistort(c.distortion, {(x - k.cx_px) / k.fx_px, (y - k.cy_px) / k.fy_px});
          rays.emplace_back(point_jacobian(c, {xy.x(), xy.y(), 1}));
          const auto by_turn = rays.back()->by_pose.leftCols<3>();
          turn_turn += by_turn.transpose() * by_turn;
          turn_intrinsics += by_turn.transpose() * rays.back()->by_intrinsics;
        } catch (const ArgumentError&) {
          rays.emplace_back(std::nullopt);
        }
      }
    const Eigen::MatrixXd turn = -turn_turn.ldlt().solve(turn_intrinsics);
    for (const auto& ray : rays)
      effect_.push_back(ray ? Jacobian(ray->by_intrinsics + ray->by_pose.leftCols<3>() * turn)
                            : Jacobian());
  }

  int rows() const { return rows_; }
  /// Variance in px^2 at a node, NaN where there is no ray.
  double variance(int row, int column, const Eigen::MatrixXd& covariance) const {
    const Jacobian& J = effect_[static_cast<std::size_t>(row * kColumns + column)];
    return J.size() == 0 ? std::numeric_limits<double>::quiet_NaN()
                         : (J * covariance * J.transpose()).trace();
  }
  double mean_px(const Eigen::MatrixXd& covariance) const {
    double sum = 0, count = 0;
    for (int r = 0; r < rows_; ++r)
      for (int c = 0; c < kColumns; ++c)
        if (const double v = variance(r, c, covariance); !std::isnan(v)) sum += v, ++count;
    return std::sqrt(sum / count);
  }

 private:
  int rows_;
  std::vector<Jacobian> effect_;
};

/// J^T J of the intrinsics from one board at a pose, in px^2; empty unless the picture shows it.
Eigen::MatrixXd board_normal(const CameraCalibration& c, const Board& board,
                             const RigidTransform& T_camera_board) {
  const Intrinsics& k = c.intrinsics;
  const auto rows = static_cast<Eigen::Index>(2 * board.corners());
  Eigen::MatrixXd J_camera(rows, c.covariance.rows()), J_board(rows, 6);
  Eigen::Index row = 0;
  for (const Eigen::Vector3d& p_board : corners_mm(board)) {
    const Eigen::Vector3d p = T_camera_board * p_board;
    if (!(p.z() > 0)) return {};
    const Eigen::Vector2d px = project(k, c.distortion, p);
    if (!(px.x() > kMarginPx && px.y() > kMarginPx && px.x() < k.width_px - 1 - kMarginPx &&
          px.y() < k.height_px - 1 - kMarginPx))
      return {};
    const PointJacobian J = point_jacobian(c, p);
    J_camera.middleRows<2>(row) = J.by_intrinsics;
    J_board.middleRows<2>(row) = J.by_pose;
    row += 2;
  }
  detail::SharedInformation information;
  information.add_board(J_camera, J_board, Eigen::VectorXd::Zero(rows));
  return information.normal();
}

}  // namespace

ScalarImage projection_uncertainty_px(const CameraCalibration& c) {
  const PictureGrid grid(c);
  cv::Mat1d nodes(grid.rows(), kColumns);
  for (int r = 0; r < nodes.rows; ++r)
    for (int column = 0; column < kColumns; ++column)
      nodes(r, column) = std::sqrt(grid.variance(r, column, c.covariance));
  ScalarImage map(c.intrinsics.width_px, c.intrinsics.height_px);
  for (int y = 0; y < map.height(); ++y) {
    const double v = y * (nodes.rows - 1.0) / std::max(1, map.height() - 1);
    const int r = std::min(static_cast<int>(v), nodes.rows - 2);
    for (int x = 0; x < map.width(); ++x) {
      const double u = x * (kColumns - 1.0) / std::max(1, map.width() - 1);
      const int column = std::min(static_cast<int>(u), kColumns - 2);
      const double right = u - column, down = v - r;
      map.pixels(y, x) = static_cast<float>(
          (1 - down) * ((1 - right) * nodes(r, column) + right * nodes(r, column + 1)) +
          down * ((1 - right) * nodes(r + 1, column) + right * nodes(r + 1, column + 1)));
    }
  }
  return map;
}

double mean_uncertainty_px(const CameraCalibration& c) {
  return PictureGrid(c).mean_px(c.covariance);
}

BoardAdvice next_board(const CameraCalibration& c, const Board& board) {
  const PictureGrid grid(c);
  const Intrinsics& k = c.intrinsics;
  const Eigen::MatrixXd information = c.covariance.inverse();
  static constexpr const char* kPlaces[3][3] = {{"upper left", "upper middle", "upper right"},
                                                {"middle left", "middle", "middle right"},
                                                {"lower left", "lower middle", "lower right"}};
  struct Tilt {
    double x_rad, y_rad;
    const char* text;
  };
  static constexpr Tilt kTilts[] = {{0, 0, "facing the camera"},
                                    {kTilt_rad, 0, "tilted 40 degrees, upper edge away"},
                                    {-kTilt_rad, 0, "tilted 40 degrees, lower edge away"},
                                    {0, kTilt_rad, "tilted 40 degrees, right edge away"},
                                    {0, -kTilt_rad, "tilted 40 degrees, left edge away"}};
  const Eigen::Vector3d middle(0.5 * (board.columns - 1) * board.square_mm,
                               0.5 * (board.rows - 1) * board.square_mm, 0);
  BoardAdvice best;
  best.mean_then_px = std::numeric_limits<double>::infinity();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      for (const double share : {0.6, 0.35})  // of the picture's width that the board spans
        for (const Tilt& tilt : kTilts) {
          // As far out as the board's size allows, measured by its unturned width and height.
          const double reach_x = (1 - share) / 2 * 0.9;
          const double reach_y = 0.9 * std::max(0.0, 0.5 - share / 2 * board.rows / board.columns *
                                                               k.width_px / k.height_px);
          const double x = (0.5 + (column - 1) * reach_x) * (k.width_px - 1);
          const double y = (0.5 + (row - 1) * reach_y) * (k.height_px - 1);
          const double z_mm = k.fx_px * 2 * middle.x() / (share * k.width_px);
          Eigen::Vector2d xy;
          try {
            xy = undistort(c.distortion, {(x - k.cx_px) / k.fx_px, (y - k.cy_px) / k.fy_px});
          } catch (const ArgumentError&) {
            continue;
          }
          RigidTransform T;
          T.R = (Eigen::AngleAxisd(-tilt.x_rad, Eigen::Vector3d::UnitX()) *
                 Eigen::AngleAxisd(-tilt.y_rad, Eigen::Vector3d::UnitY()))
                    .toRotationMatrix();
          T.t_mm = z_mm * Eigen::Vector3d(xy.x(), xy.y(), 1) - T.R * middle;
          const Eigen::MatrixXd normal = board_normal(c, board, T);
          if (normal.size() == 0) continue;
          const double mean = grid.mean_px(
              (information + normal / (c.corner_sigma_px * c.corner_sigma_px)).inverse());
          if (mean >= best.mean_then_px) continue;
          char text[200];
          std::snprintf(text, sizeof text,
                        "hold the board %s in the picture, %s, at %.0f mm: the mean uncertainty "
                        "would fall to %.3f px",
                        kPlaces[row][column], tilt.text, z_mm, mean);
          best = {T, mean, text};
        }
  if (std::isinf(best.mean_then_px))
    throw ArgumentError("no pose shows the whole board in the picture",
                        "check --board and the calibration");
  return best;
}

std::vector<std::string> loose_coefficients(const CameraCalibration& c) {
  constexpr double kShareOfRadius = 0.1;
  const Intrinsics& k = c.intrinsics;
  const double r = std::hypot(std::max(k.cx_px, k.width_px - 1 - k.cx_px) / k.fx_px,
                              std::max(k.cy_px, k.height_px - 1 - k.cy_px) / k.fy_px);
  const std::vector<std::string> names = coefficient_names(c.model);
  const Eigen::VectorXd sigma = c.sigma();
  const bool fisheye = c.model == DistortionModel::kFisheye;
  std::vector<std::string> loose;
  for (std::size_t i = 0; i < names.size(); ++i) {
    // What one unit does to a point at r, relative to r: r^2n for the nth radial coefficient (of
    // the denominator from k4 on, unless it is a fisheye), 3 r for a tangential one.
    const int n = names[i][1] - '0';
    const double effect =
        names[i][0] == 'p' ? 3 * r : std::pow(r, 2 * (n > 3 && !fisheye ? n - 3 : n));
    if (sigma[static_cast<Eigen::Index>(4 + i)] * effect > kShareOfRadius)
      loose.push_back(names[i]);
  }
  return loose;
}

}  // namespace wheatstone
