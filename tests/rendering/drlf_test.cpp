#include "rendering/light_field/drlf.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/random.h"
#include "rendering/light_field/focus.h"
#include "tests/rendering/synthetic_light_field.h"

namespace wheatstone::testing {
namespace {

Eigen::Vector3d vector3(const nlohmann::json& j) {
  return {j[0].get<double>(), j[1].get<double>(), j[2].get<double>()};
}
Eigen::Matrix3d matrix3(const nlohmann::json& j) {
  Eigen::Matrix3d m;
  for (int r = 0; r < 3; ++r) m.row(r) = vector3(j[r]).transpose();
  return m;
}

/// The vectors are written with 10 significant digits, rotations included.
void expect_close(double actual, double expected) {
  EXPECT_NEAR(actual, expected, 1e-5 + 1e-7 * std::abs(expected));
}

TEST(DrlfWarp, LikeTheReferenceVectors) {
  std::ifstream in(std::string(WHEATSTONE_SOURCE_DIR) + "/tests/vectors/drlf_warp.json");
  const auto file = nlohmann::json::parse(in);
  for (const auto& c : file["cases"]) {
    VirtualCamera camera;
    camera.K << c["fx"].get<double>(), c["skew"].get<double>(), c["x0"].get<double>(), 0,
        c["fy"].get<double>(), c["y0"].get<double>(), 0, 0, 1;
    const Eigen::Matrix3d R = matrix3(c["R_v"]);
    camera.T_camera_world = {R, -(R * vector3(c["C_v"]))};
    camera.width = camera.height = 1;
    DrlfOptions options;
    options.focal_plane.normal = vector3(c["plane_normal"]);
    options.focal_plane.offset_mm = options.focal_plane.normal.dot(vector3(c["plane_point"]));
    std::vector<LightFieldView> views;
    const Eigen::Matrix3d K = matrix3(c["K_data"]);
    for (const auto& centre : c["data_centers"]) {
      LightFieldView view;
      view.intrinsics = {K(0, 0), K(1, 1), 0, K(0, 2), K(1, 2), 1, 1};
      view.light_cd_m2 = RgbImage(1, 1);
      view.T_camera_world.t_mm = -vector3(centre);
      views.push_back(view);
    }
    const CameraMesh mesh(views);
    const DrlfGeometry geometry = make_drlf_geometry(views, mesh, camera, options);
    const Eigen::Matrix4d M = virtual_matrix(camera, options.focal_plane);
    for (int r = 0; r < 4; ++r)
      for (int k = 0; k < 4; ++k) expect_close(M(r, k), c["M_KPE"][r][k]);

    for (const auto& result : c["results"]) {
      const Eigen::Vector2d pixel(result["pixel"][0].get<double>(),
                                  result["pixel"][1].get<double>());
      const Eigen::Vector3d X = focal_plane_point(M, pixel);
      for (int k = 0; k < 3; ++k) expect_close(X[k], result["world"][k]);
      const Eigen::Vector3d p(pixel.x(), pixel.y(), 1);
      EXPECT_GT(geometry.inverse_depth_row.dot(p), 0);
      const Eigen::Vector2d st = aperture_point(geometry.H_aperture_virtual * p);
      // The rail is symmetric about 0, so s is world x up to the sign of the axis.
      const double sign = mesh.positions_mm()[4].x() > 0 ? 1 : -1;
      expect_close(sign * st.x(), result["aperture_point"][0]);
      EXPECT_EQ(mesh.nearest(st), result["nearest"].get<int>());
      std::vector<double> tent(views.size()), gauss(views.size());
      const CellWeights w = mesh.weights_at(st);
      for (int k = 0; k < w.cell->camera_count; ++k) tent[w.cell->cameras[k]] += w.weights[k];
      double sum = 0;
      for (std::size_t i = 0; i < views.size(); ++i) {
        const Eigen::Vector2d d = mesh.positions_mm()[i] - st;
        sum += gauss[i] = std::exp(-d.squaredNorm() / (2 * 20 * 20));
        const Eigen::Vector3d q = geometry.H_data_virtual[i] * p;
        EXPECT_GT(q.z(), 0);
        for (int k = 0; k < 2; ++k) expect_close(q[k] / q.z(), result["data_px"][i][k]);
      }
      for (std::size_t i = 0; i < views.size(); ++i) {
        expect_close(tent[i], result["tent"][i]);
        expect_close(gauss[i] / sum, result["gauss20"][i]);
      }
    }
  }
}

class DrlfAperture : public ::testing::TestWithParam<DrlfOptions::Aperture> {};
INSTANTIATE_TEST_SUITE_P(All, DrlfAperture,
                         ::testing::Values(DrlfOptions::Aperture::kNearest,
                                           DrlfOptions::Aperture::kLinear,
                                           DrlfOptions::Aperture::kGaussian));

TEST_P(DrlfAperture, APaintedFocalPlaneComesBackExactly) {
  for (const auto& views : {painted_grid(5, 1, 20), painted_grid(3, 3, 20)}) {
    VirtualCamera camera = virtual_camera({7, -3, 550});
    camera.K(0, 0) = camera.K(1, 1) = 500;  // every data camera sees all of it
    // Turned a little: the plane's light is affine in the world, not in this camera's pixels.
    camera.T_camera_world.R =
        Eigen::AngleAxisd(0.05, Eigen::Vector3d(1, 2, 0.5).normalized()).toRotationMatrix() *
        camera.T_camera_world.R;
    camera.T_camera_world.t_mm = -(camera.T_camera_world.R * Eigen::Vector3d(7, -3, 550));
    const DrlfOptions options = focused_on_the_plane(GetParam());
    const DrlfResult out = render_drlf_cpu(views, camera, options);
    const Eigen::Matrix4d M = virtual_matrix(camera, options.focal_plane);
    for (int j = 0; j < camera.height; ++j)
      for (int i = 0; i < camera.width; ++i) {
        ASSERT_EQ(out.coverage.pixels(j, i), 1.0f) << i << "," << j;
        const Eigen::Vector3d light = painted_light(focal_plane_point(M, Eigen::Vector2d(i, j)));
        for (int k = 0; k < 3; ++k)
          ASSERT_NEAR(out.light_cd_m2.pixels(j, i)[k], light[k], 1e-3) << i << "," << j;
      }
  }
}

TEST_P(DrlfAperture, AVirtualCameraOnADataCameraShowsItsPicture) {
  if (GetParam() == DrlfOptions::Aperture::kGaussian) return;  // blends all cameras by design
  auto views = painted_grid(3, 3, 20);
  RandomStream random(5, 0);
  for (auto& view : views)
    for (auto& p : view.light_cd_m2.pixels)
      p = cv::Vec3f::all(static_cast<float>(1000 * random.uniform()));
  DrlfOptions options = focused_on_the_plane(GetParam());
  options.focal_plane.offset_mm = 123;  // where it is focused does not matter
  VirtualCamera camera;
  camera.K = views[4].intrinsics.K();
  camera.T_camera_world = views[4].T_camera_world;
  camera.width = 160;
  camera.height = 120;
  const DrlfResult out = render_drlf_cpu(views, camera, options);
  EXPECT_LT(cv::norm(out.light_cd_m2.pixels, views[4].light_cd_m2.pixels, cv::NORM_INF), 1e-3);
}

TEST_P(DrlfAperture, WhatNoCameraSeesIsBlackAndUncovered) {
  const auto views = painted_grid(3, 1, 20);
  VirtualCamera camera = virtual_camera({0, 0, 550});
  camera.K(0, 0) = camera.K(1, 1) = 60;  // a wide angle looks past the data images
  const DrlfResult out = render_drlf_cpu(views, camera, focused_on_the_plane(GetParam()));
  EXPECT_EQ(out.coverage.pixels(0, 0), 0);
  EXPECT_EQ(out.light_cd_m2.pixels(0, 0), cv::Vec3f(0, 0, 0));
  EXPECT_EQ(out.coverage.pixels(camera.height / 2, camera.width / 2), 1);
  for (const float c : out.coverage.pixels) {
    EXPECT_GE(c, 0);
    EXPECT_LE(c, 1);
  }
  // Everything behind the virtual camera is unseen as well.
  DrlfOptions behind = focused_on_the_plane(GetParam());
  behind.focal_plane.offset_mm = 2000;
  EXPECT_EQ(cv::norm(render_drlf_cpu(views, camera, behind).coverage.pixels), 0);
}

TEST(Drlf, SameBytesForEveryNumberOfThreads) {
  const auto views = painted_grid(3, 3, 20);
  const VirtualCamera camera = virtual_camera({4, 5, 560});
  const DrlfOptions options = focused_on_the_plane(DrlfOptions::Aperture::kGaussian);
  const DrlfResult many = render_drlf_cpu(views, camera, options);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const DrlfResult single = render_drlf_cpu(views, camera, options);
  EXPECT_EQ(cv::norm(many.light_cd_m2.pixels, single.light_cd_m2.pixels, cv::NORM_INF), 0);
}

TEST(Drlf, ImpossibleArgumentsAreRefused) {
  auto views = painted_grid(3, 1, 20);
  const VirtualCamera camera = virtual_camera({0, 0, 550});
  DrlfOptions options = focused_on_the_plane(DrlfOptions::Aperture::kLinear);
  EXPECT_THROW(render_drlf_cpu({}, camera, options), ArgumentError);
  EXPECT_THROW(render_drlf_cpu(views, VirtualCamera{}, options), ArgumentError);
  options.focal_plane.offset_mm = 550;  // through the virtual camera
  EXPECT_THROW(render_drlf_cpu(views, camera, options), ArgumentError);
  options = focused_on_the_plane(DrlfOptions::Aperture::kGaussian);
  options.gaussian_sigma_mm = 0;
  EXPECT_THROW(render_drlf_cpu(views, camera, options), ArgumentError);
  views[1].light_cd_m2 = RgbImage(10, 10);
  EXPECT_THROW(render_drlf_cpu(views, camera, focused_on_the_plane(DrlfOptions::Aperture::kLinear)),
               ArgumentError);
}

TEST(FindFocalPlane, FindsTheDepthOfATexturedPlane) {
  // Texture by smooth noise on the plane z = 0, seen from 600 mm.
  auto views = painted_grid(5, 1, 20);
  for (auto& view : views) {
    const Eigen::Vector3d centre = camera_centre(view.T_camera_world);
    for (int j = 0; j < 120; ++j)
      for (int i = 0; i < 160; ++i) {
        const double x = centre.x() + (i - 79.5) * 2, y = centre.y() - (j - 59.5) * 2;
        view.light_cd_m2.pixels(j, i) = cv::Vec3f::all(static_cast<float>(
            100 + 40 * std::sin(0.13 * x + 0.05 * y) + 40 * std::sin(0.071 * x - 0.09 * y + 1)));
      }
  }
  const PlaneInWorld plane =
      find_focal_plane(views, straight_pose({3, 2, kCameraZmm}), 300, 1500, 40);
  EXPECT_NEAR(plane.normal.norm(), 1, 1e-12);
  // normal . p = offset at the world's z = 0, and perpendicular to the view.
  EXPECT_NEAR(std::abs(plane.normal.z()), 1, 1e-12);
  EXPECT_NEAR(plane.offset_mm / plane.normal.z(), kPlaneZmm, 5);
  const RigidTransform pose = straight_pose({0, 0, kCameraZmm});
  EXPECT_THROW(find_focal_plane(views, pose, 0, 100, 10), ArgumentError);
  EXPECT_THROW(find_focal_plane(views, pose, 300, 100, 10), ArgumentError);
  EXPECT_THROW(find_focal_plane(views, pose, 100, 300, 2), ArgumentError);
  EXPECT_THROW(find_focal_plane(std::span(views).first(1), pose, 100, 300, 9), ArgumentError);
}

}  // namespace
}  // namespace wheatstone::testing
