#include "calib/camera_solver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>

#include "core/png.h"
#include "synthetic_boards.h"
#include "tests/error_text.h"
#include "tests/shared_data.h"

namespace wheatstone {
namespace {

using testing::HasSubstr;

const Board kBoard{9, 6, 25};
const Board kSmallBoard{6, 4, 30};

std::string failure(const std::vector<BoardView>& views, const Board& board) {
  return error_of([&] { solve_camera(views, board, 640, 480); });
}

/// data/camera_calibration/opencv_9x6/<side>NN.jpg
std::vector<BoardView> photographed(const std::filesystem::path& folder, const std::string& side) {
  std::vector<BoardView> views;
  for (const char* number : {"01", "02", "04", "05", "06", "08", "09", "12", "13"}) {
    const auto corners = find_board(read_grey_picture(folder / (side + number + ".jpg")), kBoard);
    EXPECT_TRUE(corners) << side << number;
    if (corners) views.push_back({side + number, *corners});
  }
  return views;
}

// A noise of 1e-3 px: without any, the descent has no scale to stop by.
TEST(CameraSolver, AllButExactWithHardlyAnyNoiseForEveryModel) {
  for (const auto model : {DistortionModel::kRadtan4, DistortionModel::kRadtan5,
                           DistortionModel::kRadtan8, DistortionModel::kFisheye}) {
    SyntheticCamera camera;
    if (model == DistortionModel::kRadtan5) camera.lens.k3 = 0.1;
    if (model == DistortionModel::kRadtan8)
      camera.lens = {0.3, 0.1, 1e-3, -1e-3, 0.02, 0.4, 0.2, 0.05};
    if (model == DistortionModel::kFisheye) {
      camera.k.fx_px = camera.k.fy_px = 300;
      camera.lens = {0.02, -0.01, 0, 0, 0.004, -0.001, 0, 0, true};
    }
    const CameraCalibration c =
        solve_camera(see_boards(camera, kBoard, 8, 1e-3, 1), kBoard, 640, 480, model);
    EXPECT_LT(c.rms_px, 2e-3) << to_string(model);
    EXPECT_NEAR(c.intrinsics.fx_px, camera.k.fx_px, 0.1) << to_string(model);
    EXPECT_NEAR(c.intrinsics.cy_px, camera.k.cy_px, 0.1) << to_string(model);
    for (double x = 20; x < 640; x += 60)  // the rational model's coefficients are hardly unique
      for (double y = 20; y < 480; y += 60) {
        const Eigen::Vector2d u = undistort(camera.lens, {(x - camera.k.cx_px) / camera.k.fx_px,
                                                          (y - camera.k.cy_px) / camera.k.fy_px});
        EXPECT_LT(
            (project(c.intrinsics, c.distortion, u.homogeneous()) - Eigen::Vector2d(x, y)).norm(),
            0.02)
            << to_string(model);
      }
  }
}

TEST(CameraSolver, AgreesWithOpenCvOnPhotographs) {
  const auto folder = shared_folder("data/camera_calibration/opencv_9x6");
  REQUIRE_SHARED(folder);
  for (const std::string side : {"left", "right"}) {
    const std::vector<BoardView> views = photographed(folder, side);
    std::vector<std::vector<cv::Point3f>> object;
    std::vector<std::vector<cv::Point2f>> image;
    for (const BoardView& v : views) {
      object.emplace_back();
      image.emplace_back();
      for (const auto& p : corners_mm(kBoard)) object.back().emplace_back(p.x(), p.y(), 0);
      for (const auto& p : v.corners_px) image.back().emplace_back(p.x(), p.y());
    }
    cv::Matx33d K;
    cv::Mat distortion;
    const double rms =
        cv::calibrateCamera(object, image, {640, 480}, K, distortion, cv::noArray(), cv::noArray());
    const CameraCalibration c = solve_camera(views, kBoard, 640, 480);
    const Eigen::VectorXd sigma = c.sigma();
    EXPECT_NEAR(c.rms_px, rms, 1e-4);
    // Far within one standard deviation: it is the same minimum.
    EXPECT_NEAR(c.intrinsics.fx_px, K(0, 0), 0.05 * sigma[0]);
    EXPECT_NEAR(c.intrinsics.fy_px, K(1, 1), 0.05 * sigma[1]);
    EXPECT_NEAR(c.intrinsics.cx_px, K(0, 2), 0.05 * sigma[2]);
    EXPECT_NEAR(c.intrinsics.cy_px, K(1, 2), 0.05 * sigma[3]);
    RecordProperty(side + "_rms_px", std::to_string(c.rms_px));
    RecordProperty(side + "_fx_px",
                   std::to_string(c.intrinsics.fx_px) + "+-" + std::to_string(sigma[0]));
    if (side == "right")  // picture 05 fits 3.3 times worse than the median
      EXPECT_THAT(outlier_boards(c), testing::ElementsAre(3u));
    else
      EXPECT_TRUE(outlier_boards(c).empty());
  }
}

// Residuals are drawn anew within each picture (the right camera's pictures differ in noise, which
// a covariance from one common variance would not see), made larger for the parameters that the fit
// has spent.
TEST(CameraSolver, SigmasMatchABootstrap) {
  const auto folder = shared_folder("data/camera_calibration/opencv_9x6");
  REQUIRE_SHARED(folder);
  for (const std::string side : {"left", "right"}) {
    const std::vector<BoardView> views = photographed(folder, side);
    const CameraCalibration c = solve_camera(views, kBoard, 640, 480);
    const double n = 2.0 * static_cast<double>(views.size() * kBoard.corners());
    const double p =
        static_cast<double>(c.covariance.rows()) + 6.0 * static_cast<double>(views.size());
    const int draws = 150;
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(9), squares = sum;
    for (int draw = 0; draw < draws; ++draw) {
      RandomStream random(11, static_cast<std::uint64_t>(draw));
      std::vector<BoardView> drawn = views;
      for (std::size_t v = 0; v < views.size(); ++v)
        for (std::size_t i = 0; i < kBoard.corners(); ++i)
          drawn[v].corners_px[i] +=
              c.residuals_px[v][i] -
              std::sqrt(n / (n - p)) * c.residuals_px[v][random.next() % kBoard.corners()];
      const CameraCalibration b = solve_camera(drawn, kBoard, 640, 480);
      Eigen::VectorXd x(9);
      x << b.intrinsics.fx_px, b.intrinsics.fy_px, b.intrinsics.cx_px, b.intrinsics.cy_px,
          b.distortion.k1, b.distortion.k2, b.distortion.p1, b.distortion.p2, b.distortion.k3;
      sum += x;
      squares += x.cwiseAbs2();
    }
    const Eigen::VectorXd spread = ((squares - sum.cwiseAbs2() / draws) / (draws - 1)).cwiseSqrt();
    for (int i = 0; i < 9; ++i) {
      RecordProperty(side + "_ratio_" + std::to_string(i),
                     std::to_string(c.sigma()[i] / spread[i]));
      EXPECT_NEAR(c.sigma()[i] / spread[i], 1, 0.2) << side << ' ' << i;
    }
  }
}

// 600 runs, because the percentage of 200 scatters by 1.5.
TEST(CameraSolver, IntervalsContainTheTruth) {
  const SyntheticCamera camera;
  const double truth[] = {600, 605, 330, 235, -0.12, 0.06, 8e-4, -6e-4};
  const int runs = 600;
  int inside[8] = {};
  for (int run = 0; run < runs; ++run) {
    const CameraCalibration c = solve_camera(
        see_boards(camera, kSmallBoard, 10, 0.2, 1000 + static_cast<std::uint64_t>(run)),
        kSmallBoard, 640, 480, DistortionModel::kRadtan4);
    const auto d = c.distortion.coefficients();
    const double found[] = {c.intrinsics.fx_px,
                            c.intrinsics.fy_px,
                            c.intrinsics.cx_px,
                            c.intrinsics.cy_px,
                            d[0],
                            d[1],
                            d[2],
                            d[3]};
    for (int i = 0; i < 8; ++i) inside[i] += std::abs(found[i] - truth[i]) < 1.96 * c.sigma()[i];
  }
  for (int i = 0; i < 8; ++i) {
    const double percent = 100.0 * inside[i] / runs;
    RecordProperty("percent_" + std::to_string(i), std::to_string(percent));
    EXPECT_GE(percent, 92) << i;
    EXPECT_LE(percent, 98) << i;
  }
}

TEST(CameraSolver, HeldOutBoardsAndOutliers) {
  const SyntheticCamera camera;
  std::vector<BoardView> views = see_boards(camera, kSmallBoard, 10, 0.1, 5);
  RandomStream random(6, 1);
  for (Eigen::Vector2d& p : views[7].corners_px)
    p += 2 * Eigen::Vector2d(random.normal(), random.normal());
  const CameraCalibration c = solve_camera(views, kSmallBoard, 640, 480);
  EXPECT_THAT(outlier_boards(c), testing::ElementsAre(7u));
  views.erase(views.begin() + 7);
  const auto held_out = cross_validate(views, kSmallBoard, 640, 480, DistortionModel::kRadtan4, 3);
  ASSERT_EQ(held_out.size(), 9u);
  for (const double rms : held_out) {
    EXPECT_GT(rms, 0.05);
    EXPECT_LT(rms, 0.3);
  }
}

TEST(CameraSolver, WhatDeterminesNothingIsRefused) {
  const SyntheticCamera camera;
  std::vector<BoardView> views = see_boards(camera, kSmallBoard, 2, 0.1, 5);
  EXPECT_THAT(failure(views, kSmallBoard), HasSubstr("3 pictures, not 2"));
  views = see_boards(camera, kSmallBoard, 6, 0.1, 5, 0.001);
  EXPECT_THAT(failure(views, kSmallBoard), HasSubstr("focal length is not determined"));
  EXPECT_THAT(failure(views, kSmallBoard), HasSubstr("tilted by 30 to 45 degrees"));
  views[3].corners_px.pop_back();
  EXPECT_THAT(failure(views, kSmallBoard), HasSubstr("board_3: 23 corners for 24"));
  EXPECT_THROW(distortion_model_from_string("radtan6"), ArgumentError);
}

TEST(Board, TextAndCorners) {
  const Board b = board_from_string("9x6", 25);
  EXPECT_EQ(b.corners(), 54u);
  EXPECT_EQ(corners_mm(b)[10], Eigen::Vector3d(25, 25, 0));
  for (const char* bad : {"", "9", "9x", "x6", "9x6x2", "2x6", "9x101", "9 x 6", "-9x6"})
    EXPECT_THROW(board_from_string(bad, 25), ArgumentError) << bad;
  EXPECT_THROW(board_from_string("9x6", 0), ArgumentError);
  EXPECT_THROW(board_from_string("9x6", std::nan("")), ArgumentError);
}

// A picture drawn with a known homography: corners are found in the board's order to 0.1 px.
TEST(Board, CornersOfADrawnBoard) {
  const Board board{5, 4, 40};
  cv::Mat1b picture(400, 480, std::uint8_t{255});
  for (int r = 0; r < picture.rows; ++r)
    for (int c = 0; c < picture.cols; ++c) {
      const int column = (c - 60) / 50, row = (r - 60) / 50;  // squares of 50 px from (60, 60)
      if (c >= 60 && r >= 60 && column < 6 && row < 5 && (column + row) % 2 == 0)
        picture(r, c) = 20;
    }
  const auto corners = find_board(picture, board);
  ASSERT_TRUE(corners);
  // Pixel edges lie half a pixel before the first dark pixel's centre.
  const bool from_the_end = (*corners)[0].x() > 240;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector2d expected(60 + 50 * (i % 5 + 1) - 0.5, 60 + 50 * (i / 5 + 1) - 0.5);
    EXPECT_LT(((*corners)[static_cast<std::size_t>(from_the_end ? 19 - i : i)] - expected).norm(),
              0.1);
  }
  EXPECT_FALSE(find_board(picture, Board{6, 4, 40}));
}

// Boards of which find_board() finds a part, and the whole ones: 54 of 9x6 on OpenCV's pictures.
TEST(Board, APartOfABoardGoesOnBeyondItAndAWholeOneDoesNot) {
  const auto folder = shared_folder("data/camera_calibration/opencv_9x6");
  REQUIRE_SHARED(folder);
  int parts = 0;
  for (const char* side : {"left", "right"})
    for (const char* number : {"01", "02", "04", "05", "06", "08", "09", "12", "13"}) {
      const cv::Mat1b grey = read_grey_picture(folder / (std::string(side) + number + ".jpg"));
      const auto whole = find_board(grey, kBoard);
      ASSERT_TRUE(whole) << side << number;
      EXPECT_FALSE(goes_on_beyond(grey, kBoard, *whole)) << side << number;
      for (const Board& smaller : {Board{8, 6, 25}, Board{7, 6, 25}, Board{6, 8, 25}})
        if (const auto part = find_board(grey, smaller)) {
          ++parts;
          EXPECT_TRUE(goes_on_beyond(grey, smaller, *part)) << side << number;
        }
    }
  EXPECT_GT(parts, 30);
  const cv::Mat1b empty(480, 640, std::uint8_t{200});
  EXPECT_THROW(goes_on_beyond(empty, kBoard, {}), ArgumentError);
  EXPECT_FALSE(goes_on_beyond(empty, Board{3, 3, 1},
                              std::vector<Eigen::Vector2d>(9, Eigen::Vector2d(5, 5))));
}

TEST(Board, BumblebeesBoardsAreWhole) {
  const auto folder = shared_folder("data/camera_calibration/bumblebee2_chess");
  REQUIRE_SHARED(folder);
  int found = 0;
  for (const char* side : {"left", "right"})
    for (const char* number : {"01", "02", "04", "05", "07", "08", "10", "11"}) {
      const cv::Mat1b grey = read_grey_picture(folder / (std::string(side) + number + ".jpg"));
      const Board board{4, 6, 30};
      if (const auto corners = find_board(grey, board)) {
        ++found;
        EXPECT_FALSE(goes_on_beyond(grey, board, *corners)) << side << number;
      }
    }
  EXPECT_EQ(found, 16);
}

}  // namespace
}  // namespace wheatstone
