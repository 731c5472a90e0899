#include "calib/charuco.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calib/stereo_solver.h"
#include "synthetic_charuco.h"
#include "tests/error_text.h"

namespace wheatstone {
namespace {

using testing::HasSubstr;

const Board& kBoard = kCharucoBoard;
const CharucoMarkers& kMarkers = kCharucoMarkers;

RigidTransform facing() {
  return {Eigen::Matrix3d::Identity(), Eigen::Vector3d(-75, -50, 300)};
}

TEST(Charuco, PartlyHiddenBoardsGiveTheCamera) {
  const SyntheticCamera camera;
  RandomStream random(11, 1);
  std::vector<BoardView> views;
  for (int i = 0; i < 10; ++i) {
    const RigidTransform T = random_board(camera, kBoard, 0.7, random);
    cv::Mat1b picture = photograph(camera, T);
    if (i % 2 == 0) {  // a hand before one end of the board
      const Eigen::Vector2d at = project(camera.k, camera.lens, T * Eigen::Vector3d(0, 50, 0));
      cv::circle(picture, {static_cast<int>(at.x()), static_cast<int>(at.y())}, 50, 120, -1);
    }
    const CharucoSighting seen = find_charuco(picture, kBoard, kMarkers);
    ASSERT_GE(seen.corner_ids.size(), kMinCorners) << i;
    if (i % 2 == 0) {
      EXPECT_LT(seen.corner_ids.size(), kBoard.corners()) << i;
    }
    views.push_back({"board_" + std::to_string(i), seen.corners_px, seen.corner_ids});
    const std::vector<Eigen::Vector3d> places = seen_corners_mm(views.back(), kBoard);
    for (std::size_t c = 0; c < places.size(); ++c)
      EXPECT_LT((project(camera.k, camera.lens, T * places[c]) - seen.corners_px[c]).norm(), 0.5)
          << i << ' ' << seen.corner_ids[c];
  }
  const CameraCalibration c = solve_camera(views, kBoard, 640, 480, DistortionModel::kRadtan4);
  const Eigen::VectorXd sigma = c.sigma();
  EXPECT_LT(c.rms_px, 0.15);
  EXPECT_NEAR(c.intrinsics.fx_px, camera.k.fx_px, 3 * sigma[0]);
  EXPECT_NEAR(c.intrinsics.fy_px, camera.k.fy_px, 3 * sigma[1]);
  EXPECT_NEAR(c.intrinsics.cx_px, camera.k.cx_px, 3 * sigma[2]);
  EXPECT_NEAR(c.intrinsics.cy_px, camera.k.cy_px, 3 * sigma[3]);
  EXPECT_LT(sigma[0], 0.01 * camera.k.fx_px);
}

TEST(Charuco, AnotherBoardIsRefused) {
  const cv::Mat1b picture = photograph({}, facing());
  const auto failure = [&](const Board& board, const CharucoMarkers& markers) {
    return error_of([&] { find_charuco(picture, board, markers); });
  };
  EXPECT_THAT(failure({6, 4, 25}, kMarkers), HasSubstr("is not on it; count the inner corners"));
  EXPECT_THAT(failure({8, 7, 25}, kMarkers), HasSubstr("its markers stand elsewhere"));
  EXPECT_THAT(failure(kBoard, {"DICT_9X9", 18}), HasSubstr("DICT_4X4_50, DICT_4X4_100"));
  EXPECT_THAT(failure({12, 9, 25}, kMarkers), HasSubstr("has 50 markers, and the board 65"));
  EXPECT_THAT(failure(kBoard, {"DICT_4X4_50", 25}), HasSubstr("smaller than its squares"));
  EXPECT_EQ(find_charuco(picture, kBoard, {"DICT_6X6_250", 18}).corner_ids.size(), 0u);
  EXPECT_EQ(dictionary_in(picture), "DICT_4X4_50");
}

TEST(Charuco, AStereoCalibrationRefusesPartsOfABoard) {
  const SyntheticCamera camera;
  const CharucoSighting seen = find_charuco(photograph(camera, facing()), kBoard, kMarkers);
  const BoardView part{"left.png", seen.corners_px, seen.corner_ids};
  const std::vector<BoardView> views{part};
  EXPECT_THAT(
      error_of([&] { solve_stereo(views, views, kBoard, 640, 480, DistortionModel::kRadtan4); }),
      HasSubstr("left.png: a stereo calibration needs the whole board"));
}

TEST(Charuco, CornersOfAViewAreChecked) {
  BoardView view{"a.png", std::vector<Eigen::Vector2d>(6), {0, 1, 2, 7, 8, 9}};
  EXPECT_EQ(seen_corners_mm(view, kBoard)[3], Eigen::Vector3d(0, 25, 0));
  view.corner_ids[5] = 35;
  EXPECT_THAT(error_of([&] { seen_corners_mm(view, kBoard); }), HasSubstr("a.png: corner 35"));
  view.corner_ids.pop_back();
  EXPECT_THAT(error_of([&] { seen_corners_mm(view, kBoard); }), HasSubstr("6 corners for 5"));
}

}  // namespace
}  // namespace wheatstone
