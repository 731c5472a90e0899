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
