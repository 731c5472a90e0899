#pragma once
// Boards before a known camera, with noise on their corners.

#include <cmath>
#include <vector>

#include "calib/camera_solver.h"
#include "core/random.h"

namespace wheatstone {

struct SyntheticCamera {
  Intrinsics k{600, 605, 0, 330, 235, 640, 480};
  Distortion lens{-0.12, 0.06, 8e-4, -6e-4, 0};
};

/// A pose that shows the whole board, tilted by up to `tilt_rad` about a random axis in its plane.
inline RigidTransform random_board(const SyntheticCamera& camera, const Board& board,
                                   double tilt_rad, RandomStream& random) {
  const Eigen::Vector3d middle(0.5 * (board.columns - 1) * board.square_mm,
                               0.5 * (board.rows - 1) * board.square_mm, 0);
  for (;;) {
    const double axis = 2 * M_PI * random.uniform();
    const double turn = tilt_rad * (2 * random.uniform() - 1);
    RigidTransform T;
    T.R = (Eigen::AngleAxisd(turn, Eigen::Vector3d(std::cos(axis), std::sin(axis), 0)) *
           Eigen::AngleAxisd(0.6 * (random.uniform() - 0.5), Eigen::Vector3d::UnitZ()))
              .toRotationMatrix();
    const double z = camera.k.fx_px * 2 * middle.x() / ((0.35 + 0.4 * random.uniform()) * 640);
    T.t_mm = Eigen::Vector3d((random.uniform() - 0.5) * 640 / camera.k.fx_px * z,
                             (random.uniform() - 0.5) * 480 / camera.k.fx_px * z, z) -
             T.R * middle;
    bool inside = true;
    for (const Eigen::Vector3d& p : corners_mm(board)) {
      const Eigen::Vector2d px = project(camera.k, camera.lens, T * p);
      inside = inside && px.x() > 5 && px.y() > 5 && px.x() < 634 && px.y() < 474;
    }
    if (inside) return T;
  }
}

inline BoardView see_board(const SyntheticCamera& camera, const Board& board,
                           const RigidTransform& T_camera_board, double noise_px,
                           RandomStream& random, const std::string& name) {
  BoardView view{name, {}};
  for (const Eigen::Vector3d& p : corners_mm(board))
    view.corners_px.push_back(project(camera.k, camera.lens, T_camera_board * p) +
                              noise_px * Eigen::Vector2d(random.normal(), random.normal()));
  return view;
}

inline std::vector<BoardView> see_boards(const SyntheticCamera& camera, const Board& board,
                                         int count, double noise_px, std::uint64_t seed,
                                         double tilt_rad = 0.7) {
  RandomStream random(seed, 1);
  std::vector<BoardView> views;
  for (int i = 0; i < count; ++i)
    views.push_back(see_board(camera, board, random_board(camera, board, tilt_rad, random),
                              noise_px, random, "board_" + std::to_string(i)));
  return views;
}

}  // namespace wheatstone
