#include "calib/stereo_solver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calib/camera_uncertainty.h"
#include "core/error.h"
#include "core/png.h"
#include "synthetic_boards.h"
#include "tests/shared_data.h"

namespace wheatstone {
namespace {

const Board kBoard{6, 4, 30};
const RigidTransform kRightLeft{
    Eigen::AngleAxisd(0.03, Eigen::Vector3d(1, 2, 0.5).normalized()).toRotationMatrix(),
    {-40, 1, 2}};

struct Pairs {
  std::vector<BoardView> left, right;
};

Pairs make_pairs(double noise_px, std::uint64_t seed) {
  const SyntheticCamera camera;
  RandomStream random(seed, 2);
  Pairs pairs;
  while (pairs.left.size() < 8) {
    const RigidTransform T = random_board(camera, kBoard, 0.7, random);
    pairs.left.push_back(see_board(camera, kBoard, T, noise_px, random, "left"));
    pairs.right.push_back(see_board(camera, kBoard, kRightLeft * T, noise_px, random, "right"));
  }
  // Finders start some boards at the other end.
  std::reverse(pairs.right[2].corners_px.begin(), pairs.right[2].corners_px.end());
  std::reverse(pairs.left[5].corners_px.begin(), pairs.left[5].corners_px.end());
  return pairs;
}

TEST(StereoSolver, RecoversTheTransformWhicheverWayBoardsAreRead) {
  const Pairs exact = make_pairs(0, 3);
  const StereoCalibration s = solve_stereo(exact.left, exact.right, kBoard, 640, 480);
  EXPECT_LT(s.rms_px, 1e-5);
  EXPECT_LT((s.T_right_left.t_mm - kRightLeft.t_mm).norm(), 1e-3);
  EXPECT_LT((s.T_right_left.R - kRightLeft.R).norm(), 1e-6);
  EXPECT_NEAR(s.baseline_mm, kRightLeft.t_mm.norm(), 1e-3);
}

TEST(StereoSolver, BaselineScattersAsPredicted) {
  const int runs = 25;
  double squares = 0, predicted = 0;
  for (int run = 0; run < runs; ++run) {
    const Pairs pairs = make_pairs(0.2, 50 + static_cast<std::uint64_t>(run));
    const StereoCalibration s =
        solve_stereo(pairs.left, pairs.right, kBoard, 640, 480, DistortionModel::kRadtan4);
    squares += std::pow(s.baseline_mm - kRightLeft.t_mm.norm(), 2) / runs;
    predicted += s.baseline_sigma_mm * s.baseline_sigma_mm / runs;
  }
  EXPECT_NEAR(std::sqrt(squares / predicted), 1, 0.4);
}

TEST(StereoSolver, Bumblebee2HasItsPublishedBaseline) {
  const auto folder = shared_folder("data/camera_calibration/bumblebee2_chess");
  REQUIRE_SHARED(folder);
  const Board board{4, 6, 30};
  Pairs pairs;
  for (const char* number : {"01", "02", "04", "05", "07", "08", "10", "11"}) {
    const auto left =
        find_board(read_grey_picture(folder / (std::string("left") + number + ".jpg")), board);
    const auto right =
        find_board(read_grey_picture(folder / (std::string("right") + number + ".jpg")), board);
    ASSERT_TRUE(left && right) << number;
    pairs.left.push_back({number, *left});
    pairs.right.push_back({number, *right});
  }
  const StereoCalibration s = solve_stereo(pairs.left, pairs.right, board, 640, 480);
  RecordProperty("baseline_mm",
                 std::to_string(s.baseline_mm) + "+-" + std::to_string(s.baseline_sigma_mm));
  RecordProperty("rms_px", std::to_string(s.rms_px));
  EXPECT_NEAR(s.baseline_mm, 120.05, 0.5);
  EXPECT_LT(s.rms_px, 0.15);
}

TEST(StereoSolver, ListsOfDifferentLengthsAreRefused) {
  const Pairs pairs = make_pairs(0, 3);
  const std::vector<BoardView> fewer(pairs.right.begin(), pairs.right.begin() + 4);
  EXPECT_THROW(solve_stereo(pairs.left, fewer, kBoard, 640, 480), ArgumentError);
}

// The map against the scatter of what calibrations predict once the best turn is taken out.
TEST(CameraUncertainty, MapMatchesTheScatterOfProjections) {
  const SyntheticCamera camera;
  const int runs = 40;
  std::vector<Eigen::Vector3d> rays;
  for (double x = 0; x <= 639; x += 71)
    for (double y = 0; y <= 479; y += 68.4)
      rays.push_back(undistort(camera.lens, {(x - camera.k.cx_px) / camera.k.fx_px,
                                             (y - camera.k.cy_px) / camera.k.fy_px})
                         .homogeneous());
  double seen = 0, predicted = 0;
  for (int run = 0; run < runs; ++run) {
    const CameraCalibration c =
        solve_camera(see_boards(camera, kBoard, 10, 0.2, 300 + static_cast<std::uint64_t>(run)),
                     kBoard, 640, 480, DistortionModel::kRadtan4);
    // Gauss-Newton for the turn, to first order: errors are small.
    Eigen::MatrixXd J(2 * rays.size(), 3);
    Eigen::VectorXd error(2 * rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(2 * i);
      const Eigen::Vector2d px = project(c.intrinsics, c.distortion, rays[i]);
      error.segment<2>(row) = px - project(camera.k, camera.lens, rays[i]);
      for (int axis = 0; axis < 3; ++axis)
        J.block<2, 1>(row, axis) =
            (project(c.intrinsics, c.distortion,
                     rays[i] + 1e-6 * Eigen::Vector3d::Unit(axis).cross(rays[i])) -
             px) /
            1e-6;
    }
    error -= J * J.colPivHouseholderQr().solve(error);
    seen += error.squaredNorm() / static_cast<double>(rays.size()) / runs;
    predicted += std::pow(mean_uncertainty_px(c), 2) / runs;
  }
  EXPECT_NEAR(std::sqrt(seen / predicted), 1, 0.25);
}

TEST(CameraUncertainty, AdviceLowersTheUncertaintyAsItSays) {
  const SyntheticCamera camera;
  std::vector<BoardView> views = see_boards(camera, kBoard, 6, 0.2, 9);
  const CameraCalibration before = solve_camera(views, kBoard, 640, 480, DistortionModel::kRadtan4);
  const BoardAdvice advice = next_board(before, kBoard);
  EXPECT_LT(advice.mean_then_px, mean_uncertainty_px(before));
  EXPECT_THAT(advice.text, testing::HasSubstr("hold the board"));
  RandomStream random(10, 1);
  views.push_back(see_board(camera, kBoard, advice.T_camera_board, 0.2, random, "advised"));
  const CameraCalibration after = solve_camera(views, kBoard, 640, 480, DistortionModel::kRadtan4);
  // The noise is estimated anew from the residuals, hence the tolerance.
  EXPECT_NEAR(mean_uncertainty_px(after) / advice.mean_then_px, 1, 0.3);
  const ScalarImage map = projection_uncertainty_px(after);
  EXPECT_EQ(map.width(), 640);
  EXPECT_EQ(map.height(), 480);
  EXPECT_GT(map.pixels(0, 0), map.pixels(240, 320));
}

}  // namespace
}  // namespace wheatstone
