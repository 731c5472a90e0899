#include "core/geometry.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/units.h"

namespace wheatstone {
namespace {

TEST(Geometry, InnerFramesCancel) {
  const RigidTransform T_a_b{
      Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix(), {1, 2, 3}};
  const RigidTransform T_b_c{Eigen::AngleAxisd(-0.7, Eigen::Vector3d::UnitY()).toRotationMatrix(),
                             {-4, 5, 6}};
  const Eigen::Vector3d p(7, -8, 9);
  EXPECT_TRUE(((T_a_b * T_b_c) * p).isApprox(T_a_b * (T_b_c * p), 1e-14));
  EXPECT_TRUE((T_a_b.inverse() * (T_a_b * p)).isApprox(p, 1e-14));
}

TEST(Geometry, CameraCentreProjectsToNothingButItsForwardAxisToThePrincipalPoint) {
  const Eigen::Vector3d centre(185, 130, 550);
  const RigidTransform T_camera_rsb{straight_R_camera_rsb(), -(straight_R_camera_rsb() * centre)};
  EXPECT_TRUE(camera_centre(T_camera_rsb).isApprox(centre, 1e-14));
  const Intrinsics k{1000, 1000, 0, 320, 240, 640, 480};
  const auto P = projection_matrix(k.K(), T_camera_rsb);
  EXPECT_NEAR((project(P, {185, 130, 0}) - Eigen::Vector2d(320, 240)).norm(), 0, 1e-10);
  // 55 mm to the right and 55 mm up at 550 mm: 100 px right, 100 px up (row decreases).
  EXPECT_NEAR((project(P, {240, 185, 0}) - Eigen::Vector2d(420, 140)).norm(), 0, 1e-10);
  EXPECT_THROW(project(P, centre), ArgumentError);
}

TEST(Geometry, UndistortInvertsDistort) {
  const Distortion d{-0.05, 0.01, 2e-4, -1e-4, 1e-3};
  for (double x = -0.4; x <= 0.4; x += 0.1)
    for (double y = -0.3; y <= 0.3; y += 0.1)
      EXPECT_NEAR((undistort(d, distort(d, {x, y})) - Eigen::Vector2d(x, y)).norm(), 0, 1e-11);
}

TEST(Geometry, UndistortInvertsRationalAndFisheyeLenses) {
  for (const Distortion& d : {Distortion{0.3, 0.1, 1e-3, -1e-3, 0.02, 0.4, 0.2, 0.05},
                             Distortion{0.02, -0.01, 0, 0, 0.004, -0.001, 0, 0, true},
                             Distortion{0, 0, 0, 0, 0, 0, 0, 0, true}})
    for (double x = -2; x <= 2; x += 0.25)
      for (double y = -1; y <= 1; y += 0.25)
        EXPECT_NEAR((undistort(d, distort(d, {x, y})) - Eigen::Vector2d(x, y)).norm(), 0, 1e-10);
}

TEST(Geometry, DistortionWorkedNumbers) {
  // An ideal fisheye: 45 degrees off the axis fall at radius pi / 4.
  const Distortion equidistant{0, 0, 0, 0, 0, 0, 0, 0, true};
  EXPECT_NEAR(distort(equidistant, {1, 0}).x(), 0.785398163397448, 1e-15);
  EXPECT_EQ(distort(equidistant, {0, 0}), Eigen::Vector2d(0, 0));
  EXPECT_FALSE(equidistant.is_zero());
  // (1 + 0.1) / (1 + 0.25) at radius 1.
  EXPECT_NEAR(distort(Distortion{0.1, 0, 0, 0, 0, 0.25}, {0, 1}).y(), 0.88, 1e-15);
}

TEST(Geometry, BeyondTheFoldOfTheDistortionIsAnError) {
  EXPECT_THROW(undistort(Distortion{-0.3, 0, 0, 0, 0}, {5, 0}), ArgumentError);
}

TEST(Geometry, PointBehindTheCameraIsAnError) {
  EXPECT_THROW(project(Intrinsics{1, 1, 0, 0, 0, 1, 1}, Distortion{}, {0, 0, -1}), ArgumentError);
}

TEST(Units, PlanesOfTheDisplayInDioptres) {
  EXPECT_NEAR(vergence_at(490.0_mm).value(), 2.0408, 5e-5);
  EXPECT_NEAR(vergence_at(850.0_mm).value(), 1.1765, 5e-5);
}

}  // namespace
}  // namespace wheatstone
