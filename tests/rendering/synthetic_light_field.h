#pragma once
// A scene that is known exactly: an affine picture painted on the plane z_world = kPlaneZmm.

#include <vector>

#include "core/rig_types.h"
#include "rendering/light_field/drlf.h"

namespace wheatstone::testing {

inline constexpr double kPlaneZmm = 0;
inline constexpr double kCameraZmm = 600;

/// Light of the painted plane, affine in world x and y, positive wherever the cameras look.
inline Eigen::Vector3d painted_light(const Eigen::Vector3d& p_world) {
  return {400 + 0.5 * p_world.x(), 500 + 0.7 * p_world.y(),
          300 - 0.3 * p_world.x() + 0.2 * p_world.y()};
}

/// A camera that looks straight at the plane (world as rsb: x right, y up, z towards the viewer).
inline RigidTransform straight_pose(const Eigen::Vector3d& centre_world) {
  const Eigen::Matrix3d R = straight_R_camera_rsb();
  return {R, -(R * centre_world)};
}

inline LightFieldView painted_view(const std::string& name, const Eigen::Vector3d& centre_world) {
  LightFieldView view;
  view.name = name;
  view.intrinsics = {300, 300, 0, 79.5, 59.5, 160, 120};
  view.T_camera_world = straight_pose(centre_world);
  view.light_cd_m2 = RgbImage(160, 120);
  for (int j = 0; j < 120; ++j)
    for (int i = 0; i < 160; ++i) {
      const double depth = centre_world.z() - kPlaneZmm;
      const Eigen::Vector3d p_world =
          view.T_camera_world.inverse() *
          Eigen::Vector3d((i - 79.5) / 300 * depth, (j - 59.5) / 300 * depth, depth);
      const Eigen::Vector3d light = painted_light(p_world);
      for (int k = 0; k < 3; ++k) view.light_cd_m2.pixels(j, i)[k] = static_cast<float>(light[k]);
    }
  return view;
}

inline std::vector<LightFieldView> painted_grid(int columns, int rows, double spacing_mm) {
  std::vector<LightFieldView> views;
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c)
      views.push_back(painted_view(std::to_string(r) + "," + std::to_string(c),
                                   {(c - 0.5 * (columns - 1)) * spacing_mm,
                                    (r - 0.5 * (rows - 1)) * spacing_mm, kCameraZmm}));
  return views;
}

inline VirtualCamera virtual_camera(const Eigen::Vector3d& centre_world) {
  VirtualCamera camera;
  camera.K << 250, 0, 47.5, 0, 250, 35.5, 0, 0, 1;
  camera.T_camera_world = straight_pose(centre_world);
  camera.width = 96;
  camera.height = 72;
  return camera;
}

inline DrlfOptions focused_on_the_plane(DrlfOptions::Aperture aperture) {
  DrlfOptions options;
  options.focal_plane = {Eigen::Vector3d::UnitZ(), kPlaneZmm};
  options.aperture = aperture;
  return options;
}

}  // namespace wheatstone::testing
