#pragma once
// RGB spaces and CIE 1931 XYZ, exactly: from primaries and white point, not from rounded tables.

#include <Eigen/Core>

namespace wheatstone {

/// CIE 1931 x, y of an RGB space.
struct RgbPrimaries {
  Eigen::Vector2d red_xy, green_xy, blue_xy, white_xy;
};
RgbPrimaries bt709_primaries();
RgbPrimaries bt2020_primaries();
RgbPrimaries display_p3_primaries();

/// XYZ = M RGB for column vectors; white (1, 1, 1) has Y = 1. With light in cd/m^2 Y is luminance.
/// Throws ArgumentError for primaries on one line or a white point outside of their triangle.
Eigen::Matrix3d xyz_from_rgb(const RgbPrimaries&);

/// X, Y, Z of luminance Y and chromaticity x, y. Throws ArgumentError unless y > 0.
Eigen::Vector3d xyz_from_xyY(const Eigen::Vector2d& xy, double Y);

}  // namespace wheatstone
