#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "capture/radiance.h"
#include "capture/rectify.h"
#include "core/error.h"

namespace wheatstone {
namespace {

TEST(Radiance, InvertsTheCameraAndClipsAtTheEnd) {
  CameraProfile p;
  p.dn_per_cd_m2_s = 250;
  p.camera_from_bt709 << 0.6, 0.3, 0.1, 0.1, 0.8, 0.1, 0.05, 0.15, 0.7;
  const Eigen::Vector3d light(120, 4, 33);
  const Eigen::Vector3d dn = 250 * p.camera_from_bt709 * light;
  cv::Mat3f image(1, 2);
  image(0, 0) = cv::Vec3f(float(dn[0]), float(dn[1]), float(dn[2]));
  image(0, 1) = cv::Vec3f(-5, 100, -1);
  const RgbImage out = to_radiance(image, p);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(out.pixels(0, 0)[c], light[c], 1e-3);
    EXPECT_GE(out.pixels(0, 1)[c], 0);
  }
  EXPECT_GT(out.pixels(0, 1)[1], 0);
  p.camera_from_bt709.setZero();
  EXPECT_THROW(to_radiance(image, p), ArgumentError);
  p.camera_from_bt709.setIdentity();
  p.dn_per_cd_m2_s = 0;
  EXPECT_THROW(to_radiance(image, p), ArgumentError);
}

const Intrinsics kCamera = {500, 500, 0, 159.5, 119.5, 320, 240};

RigidTransform pose_at(double x_mm, double turn = 0) {
  const Eigen::Matrix3d R = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix() *
                            straight_R_camera_rsb();
  return {R, -(R * Eigen::Vector3d(x_mm, 130, 550))};
}

/// A smooth picture on the back wall (z = 0): light as a function of rsb x and y.
float wall(double x, double y) {
  return float(100 + 50 * std::sin(x / 12) * std::cos(y / 15));
}

float wall_seen(const Intrinsics& k, const Distortion& d, const RigidTransform& T, double u,
                double v) {
  const Eigen::Vector2d xy = undistort(d, {(u - k.cx_px) / k.fx_px, (v - k.cy_px) / k.fy_px});
  const Eigen::Vector3d ray = T.R.transpose() * Eigen::Vector3d(xy.x(), xy.y(), 1);
  const Eigen::Vector3d o = camera_centre(T);
  const Eigen::Vector3d p = o - o.z() / ray.z() * ray;
  return wall(p.x(), p.y());
}

RgbImage photo(const Distortion& d, const RigidTransform& T) {
  RgbImage out(kCamera.width_px, kCamera.height_px);
  for (int r = 0; r < out.height(); ++r)
    for (int c = 0; c < out.width(); ++c)
      out.pixels(r, c) = cv::Vec3f::all(wall_seen(kCamera, d, T, c, r));
  return out;
}

TEST(Rectify, EveryViewShowsTheRectangleWithItsOwnPose) {
  const CommonBox box;
  const std::vector<RigidTransform> poses = {pose_at(160.3), pose_at(185, 0.02), pose_at(207.9)};
  const cv::Size size = common_size(kCamera, poses, box);
  for (const Distortion& d : {Distortion{}, Distortion{-0.1, 0.05, 0.001, -0.001, 0}})
    for (const RigidTransform& T : poses) {
      const LightFieldView view = rectify_to_common_box("v", photo(d, T), kCamera, d, T, box, size);
      ASSERT_EQ(view.light_cd_m2.pixels.size(), size);
      EXPECT_EQ(view.intrinsics.width_px, size.width);
      double worst = 0;
      for (double x = box.min_mm.x(); x <= box.max_mm.x(); x += 10)
        for (double y = box.min_mm.y(); y <= box.max_mm.y(); y += 10) {
          const Eigen::Vector2d px = project(view.intrinsics, {}, T * Eigen::Vector3d(x, y, 0));
          ASSERT_GE(px.minCoeff(), box.margin_px - 1);
          ASSERT_LE(px.x(), size.width - box.margin_px);
          ASSERT_LE(px.y(), size.height - box.margin_px);
          const int c = int(std::lround(px.x())), r = int(std::lround(px.y()));
          worst = std::max(worst, std::abs(double(view.light_cd_m2.pixels(r, c)[1]) -
                                           wall_seen(view.intrinsics, {}, T, c, r)));
        }
      EXPECT_LT(worst, d.is_zero() ? 1e-3 : 0.1);
    }
}

TEST(Rectify, AnOwnCropIsSmallerAndShowsTheSame) {
  const CommonBox box;
  const std::vector<RigidTransform> poses = {pose_at(101.5), pose_at(160.3), pose_at(185, 0.02)};
  const Distortion d{-0.1, 0.05, 0.001, -0.001, 0};
  const cv::Size size = common_size(kCamera, poses, box);
  for (const RigidTransform& T : poses) {
    const RgbImage taken = photo(d, T);
    const LightFieldView common = rectify_to_common_box("v", taken, kCamera, d, T, box, size);
    const LightFieldView own = rectify_to_own_box("v", taken, kCamera, d, T, box);
    ASSERT_LE(own.light_cd_m2.width(), size.width);
    ASSERT_LE(own.light_cd_m2.height(), size.height);
    EXPECT_EQ(own.intrinsics.width_px, own.light_cd_m2.width());
    EXPECT_EQ(own.intrinsics.fx_px, kCamera.fx_px);
    const auto dx = static_cast<int>(std::lround(common.intrinsics.cx_px - own.intrinsics.cx_px));
    const auto dy = static_cast<int>(std::lround(common.intrinsics.cy_px - own.intrinsics.cy_px));
    int compared = 0;
    for (int r = 0; r < own.light_cd_m2.height(); ++r)
      for (int c = 0; c < own.light_cd_m2.width(); ++c) {
        if (r + dy < 0 || c + dx < 0 || r + dy >= size.height || c + dx >= size.width) continue;
        ++compared;
        ASSERT_EQ(own.light_cd_m2.pixels(r, c), common.light_cd_m2.pixels(r + dy, c + dx));
      }
    EXPECT_GT(compared,
              static_cast<int>(0.8 * static_cast<double>(own.light_cd_m2.pixels.total())));
  }
  EXPECT_THROW(rectify_to_own_box("v", photo({}, pose_at(-900)), kCamera, {}, pose_at(-900), box),
               ArgumentError);
}

TEST(Rectify, ACropNeverLeavesThePhoto) {
  const CommonBox box;
  const Distortion d{-0.1, 0.05, 0.001, -0.001, 0};
  const RigidTransform T = pose_at(270);  // the rectangle's left edge is out of this photo
  const cv::Size size = common_size(kCamera, std::vector{T}, box);
  const LightFieldView view = rectify_to_common_box("v", photo(d, T), kCamera, d, T, box, size);
  EXPECT_LT(project(view.intrinsics, {}, T * Eigen::Vector3d(box.min_mm.x(), 130, 0)).x(), 0);
  double worst = 0;
  for (int r = 0; r < size.height; ++r)
    for (int c = 0; c < size.width; ++c)
      worst = std::max(worst, std::abs(double(view.light_cd_m2.pixels(r, c)[1]) -
                                       wall_seen(view.intrinsics, {}, T, c, r)));
  EXPECT_LT(worst, 0.2);
}

TEST(Rectify, NoNegativeLightAtSharpEdges) {
  const RigidTransform T = pose_at(185);
  const Distortion d{-0.1, 0.05, 0, 0, 0};
  RgbImage image(kCamera.width_px, kCamera.height_px);
  for (int r = 0; r < image.height(); ++r)
    for (int c = 0; c < image.width(); ++c)
      image.pixels(r, c) = cv::Vec3f::all((r / 7 + c / 5) % 2 ? 10000.0f : 0.0f);
  const CommonBox box;
  const cv::Size size = common_size(kCamera, std::vector{T}, box);
  const LightFieldView view = rectify_to_common_box("v", image, kCamera, d, T, box, size);
  double low = 0, high = 0;
  cv::minMaxLoc(view.light_cd_m2.pixels.reshape(1), &low, &high);
  EXPECT_GE(low, 0);
  EXPECT_LE(high, 10000);
}

TEST(Rectify, WhatCannotBeShownIsRefusedByName) {
  const CommonBox box;
  const auto refused = [&](const RigidTransform& T, cv::Size size, const std::string& part) {
    try {
      rectify_to_common_box("cam_07", RgbImage(320, 240), kCamera, {}, T, box, size);
      FAIL() << part;
    } catch (const ArgumentError& e) {
      EXPECT_THAT(e.what(), testing::HasSubstr("view cam_07"));
      EXPECT_THAT(e.what(), testing::HasSubstr(part));
    }
  };
  refused(pose_at(400), {400, 400}, "does not hold the common rectangle");
  refused(pose_at(185), {20, 20}, "too small");
  EXPECT_THROW(common_size(kCamera, {}, box), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
