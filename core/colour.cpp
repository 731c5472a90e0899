#include "core/colour.h"

#include <Eigen/LU>

#include "core/error.h"

namespace wheatstone {

namespace {
const Eigen::Vector2d kD65(0.3127, 0.3290);
}

RgbPrimaries bt709_primaries() {
  return {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, kD65};
}
RgbPrimaries bt2020_primaries() {
  return {{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, kD65};
}
RgbPrimaries display_p3_primaries() {
  return {{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, kD65};
}

Eigen::Vector3d xyz_from_xyY(const Eigen::Vector2d& xy, double Y) {
  if (!(xy.y() > 0) || !xy.allFinite())
    throw ArgumentError("a chromaticity has y of " + std::to_string(xy.y()), "give CIE 1931 x, y");
  return Y / xy.y() * Eigen::Vector3d(xy.x(), xy.y(), 1 - xy.x() - xy.y());
}

Eigen::Matrix3d xyz_from_rgb(const RgbPrimaries& p) {
  Eigen::Matrix3d columns;
  columns << xyz_from_xyY(p.red_xy, 1), xyz_from_xyY(p.green_xy, 1), xyz_from_xyY(p.blue_xy, 1);
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(columns);
  const Eigen::Vector3d luminance = lu.solve(xyz_from_xyY(p.white_xy, 1));
  if (!lu.isInvertible() || luminance.minCoeff() <= 0)
    throw ArgumentError("the primaries do not span their white point",
                        "give the x, y of red, green, blue and white");
  return columns * luminance.asDiagonal();
}

}  // namespace wheatstone
