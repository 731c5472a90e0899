#pragma once
// Pictures of a ChArUco board before a known camera.

#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/charuco.h"
#include "tests/calib/synthetic_boards.h"

namespace wheatstone {

inline const Board kCharucoBoard{7, 5, 25};
inline const CharucoMarkers kCharucoMarkers{"DICT_4X4_50", 18};

/// The board before the camera, drawn by OpenCV and seen through the lens at 3x3 samples a pixel.
inline cv::Mat1b photograph(const SyntheticCamera& camera, const RigidTransform& T_camera_board) {
  constexpr int kSquarePx = 60, kSamples = 3;
  cv::Mat1b drawn;
  cv::aruco::CharucoBoard::create(kCharucoBoard.columns + 1, kCharucoBoard.rows + 1, 25, 18,
                                  cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50))
      ->draw({(kCharucoBoard.columns + 1) * kSquarePx, (kCharucoBoard.rows + 1) * kSquarePx},
             drawn);
  const int width = kSamples * camera.k.width_px, height = kSamples * camera.k.height_px;
  cv::Mat1f map_x(height, width), map_y(height, width);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector2d px((x + 0.5) / kSamples - 0.5, (y + 0.5) / kSamples - 0.5);
      const Eigen::Vector3d ray =
          undistort(camera.lens, {(px.x() - camera.k.cx_px) / camera.k.fx_px,
                                  (px.y() - camera.k.cy_px) / camera.k.fy_px})
              .homogeneous();
      const Eigen::Vector3d normal = T_camera_board.R.col(2);
      const double d = normal.dot(T_camera_board.t_mm) / normal.dot(ray);
      const Eigen::Vector3d p = T_camera_board.R.transpose() * (ray * d - T_camera_board.t_mm);
      map_x(y, x) = static_cast<float>((p.x() / 25 + 1) * kSquarePx - 0.5);
      map_y(y, x) = static_cast<float>((p.y() / 25 + 1) * kSquarePx - 0.5);
    }
  cv::Mat1b fine, picture;
  cv::remap(drawn, fine, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_CONSTANT, 200);
  cv::resize(fine, picture, {camera.k.width_px, camera.k.height_px}, 0, 0, cv::INTER_AREA);
  return picture;
}

}  // namespace wheatstone
