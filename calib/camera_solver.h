#pragma once
// Intrinsics and lens distortion of a camera from pictures of a chessboard or ChArUco board, with
// their uncertainty.

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "calib/board.h"
#include "core/geometry.h"

namespace wheatstone {

/// Which coefficients of core's Distortion are free; the others are 0.
///   radtan4: k1 k2 p1 p2 (Kalibr's radtan, COLMAP's OPENCV)    radtan5: k1 k2 p1 p2 k3
///   radtan8: k1 k2 p1 p2 k3 k4 k5 k6 (rational)                fisheye: k1 k2 k3 k4
enum class DistortionModel { kRadtan4, kRadtan5, kRadtan8, kFisheye };
std::string to_string(DistortionModel);
DistortionModel distortion_model_from_string(const std::string&);  // throws ArgumentError
/// "k1", "k2", ... in the model's order, which is that of OpenCV's coefficient vectors.
std::vector<std::string> coefficient_names(DistortionModel);
/// The model's coefficients in the same order.
std::vector<double> coefficients(const Distortion&, DistortionModel);

/// The board in one picture. corners_px: distorted pixels, in the order of corners_mm(), or the
/// corners with these indices into it when only a part of the board is seen.
struct BoardView {
  std::string name;
  std::vector<Eigen::Vector2d> corners_px;
  std::vector<int> corner_ids = {};  // empty: all
};

/// Where the corners of a view are on the board, mm, in the view's order.
/// Throws ArgumentError, naming the view, for another number of corners than the board or the ids
/// have, for ids that the board lacks, and for fewer than kMinCorners.
std::vector<Eigen::Vector3d> seen_corners_mm(const BoardView&, const Board&);
inline constexpr std::size_t kMinCorners = 6;  // fewer hardly constrain more than the board's pose

struct CameraCalibration {
  Intrinsics intrinsics;  // skew 0
  Distortion distortion;
  DistortionModel model = DistortionModel::kRadtan5;
  /// Of fx, fy, cx, cy and coefficients(), px and 1. See solve_camera().
  Eigen::MatrixXd covariance;
  double rms_px = 0;           // root mean square length of all residuals
  double corner_sigma_px = 0;  // standard deviation of a corner per axis, from the residuals
  std::vector<RigidTransform> T_camera_board;              // one per picture
  std::vector<std::vector<Eigen::Vector2d>> residuals_px;  // predicted - seen, [picture][corner]
  std::vector<double> board_rms_px;                        // one per picture

  Eigen::VectorXd sigma() const { return covariance.diagonal().cwiseSqrt(); }
};

/// Least squares over all corners of the camera and one board pose per picture (Z. Zhang, "A
/// flexible new technique for camera calibration", PAMI 2000, sec. 3.2-3.3).
///
/// The covariance is a sandwich estimate (H. White, Econometrica 1980) in which each picture has a
/// noise of its own in x and y, from its residuals and the degrees of freedom that their leverages
/// leave: it holds as well when some pictures are blurred and their corners err more than others'.
/// It does not know errors that pictures share: a board that is not flat or a lens that the model
/// cannot follow.
///
/// Throws ArgumentError for fewer than 3 pictures, as seen_corners_mm(), for boards that turn too
/// little against each other to determine the focal length, or when nothing converges.
CameraCalibration solve_camera(std::span<const BoardView>, const Board&, int width_px,
                               int height_px, DistortionModel = DistortionModel::kRadtan5);

/// Pose of a board seen by a known camera: T_camera_board, least squares in px.
/// Throws ArgumentError, naming the view, when no pose explains it.
RigidTransform solve_board_pose(const BoardView&, const Board&, const Intrinsics&,
                                const Distortion&);

/// Root mean square residual of each picture under a camera that was calibrated without it: the
/// pictures are split into `folds` parts (picture i in part i mod folds), and each part is
/// predicted from the others with its board poses alone refined. Throws as solve_camera().
std::vector<double> cross_validate(std::span<const BoardView>, const Board&, int width_px,
                                   int height_px, DistortionModel, int folds = 5);

/// Indices of pictures whose residuals are more than 3 times the median picture's.
std::vector<std::size_t> outlier_boards(const CameraCalibration&);

}  // namespace wheatstone
