// A photographed view that was left out is made again from its neighbours (data set
// lightfield_shop: 960x640, 800 px focal length, cameras look along -z, scene at 4.6 to 19 m).

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "core/png.h"
#include "rendering/light_field/drlf.h"
#include "rendering/light_field/focus.h"
#include "rendering/metrics/pu21.h"
#include "tests/rendering/synthetic_light_field.h"

namespace wheatstone::testing {
namespace {

constexpr double kWhite = 100;  // cd/m^2

std::filesystem::path shop_folder() {
  const char* shared = std::getenv("WHEATSTONE_SHARED");
  return std::filesystem::path(shared ? shared : WHEATSTONE_DEFAULT_SHARED) / "data" /
         "lightfield_shop";
}

/// shop_<row>_<col>_<-y mm>_<x mm>_...jpg
bool parse(const std::string& name, int& row, int& column, double& x_mm, double& y_mm) {
  double minus_y = 0;
  if (std::sscanf(name.c_str(), "shop_%d_%d_%lf_%lf_", &row, &column, &minus_y, &x_mm) != 4)
    return false;
  y_mm = -minus_y;
  return true;
}

/// Views whose (row, column) is wanted; view (13, 13) apart, in `left_out`.
template <class Wanted>
std::vector<LightFieldView> read_views(Wanted wanted, LightFieldView& left_out) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(shop_folder()))
    paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<LightFieldView> views;
  for (const auto& path : paths) {
    int row = 0, column = 0;
    double x_mm = 0, y_mm = 0;
    const std::string name = path.filename().string();
    if (!parse(name, row, column, x_mm, y_mm) || !wanted(row, column)) continue;
    LightFieldView view;
    view.name = name;
    view.light_cd_m2 = read_srgb_picture(path, kWhite);
    view.intrinsics = {800, 800, 0, 479.5, 319.5, 960, 640};
    view.T_camera_world = straight_pose({x_mm, y_mm, 0});
    if (row == 13 && column == 13)
      left_out = view;
    else
      views.push_back(view);
  }
  return views;
}

void expect_better_than_neighbours(const std::string& title, std::vector<LightFieldView> views,
                                   const LightFieldView& left_out) {
  VirtualCamera camera;
  camera.K = left_out.intrinsics.K();
  camera.T_camera_world = left_out.T_camera_world;
  camera.width = 960;
  camera.height = 640;
  DrlfOptions options;
  options.focal_plane = find_focal_plane(views, camera.T_camera_world, 4000, 20000, 48);
  const DrlfResult out = render_drlf_cpu(views, camera, options);

  const Eigen::Vector3d centre = camera_centre(camera.T_camera_world);
  std::stable_sort(views.begin(), views.end(), [&](const auto& a, const auto& b) {
    return (camera_centre(a.T_camera_world) - centre).norm() <
           (camera_centre(b.T_camera_world) - centre).norm();
  });
  const RgbImage average(
      cv::Mat3f((views[0].light_cd_m2.pixels + views[1].light_cd_m2.pixels) * 0.5f));
  const double drlf = srgb_psnr(out.light_cd_m2, left_out.light_cd_m2, kWhite);
  const double nearest = srgb_psnr(views[0].light_cd_m2, left_out.light_cd_m2, kWhite);
  const double mean = srgb_psnr(average, left_out.light_cd_m2, kWhite);
  std::cout << title << ": depth "
            << -options.focal_plane.offset_mm / options.focal_plane.normal.z() << " mm, DRLF "
            << drlf << " dB, nearest view " << nearest << " dB, mean of the two nearest " << mean
            << " dB, PU21 of DRLF " << pu21_psnr_rgb(out.light_cd_m2, left_out.light_cd_m2)
            << " dB\n";
  EXPECT_GE(drlf, nearest + 2);
  EXPECT_GE(drlf, mean + 2);
}

TEST(LightFieldShop, ALeftOutViewOfTheLine) {
  if (!std::filesystem::exists(shop_folder())) GTEST_SKIP() << "no " << shop_folder();
  LightFieldView left_out;
  const auto views = read_views(
      [](int row, int column) { return row == 13 && std::abs(column - 13) <= 6; }, left_out);
  ASSERT_EQ(views.size(), 12u);
  expect_better_than_neighbours("line", views, left_out);
}

TEST(LightFieldShop, ALeftOutViewOfTheGrid) {
  if (!std::filesystem::exists(shop_folder())) GTEST_SKIP() << "no " << shop_folder();
  LightFieldView left_out;
  const auto views = read_views(
      [](int row, int column) {
        const auto near = [](int i) { return i % 2 == 1 && std::abs(i - 13) <= 4; };
        return near(row) && near(column);
      },
      left_out);
  ASSERT_EQ(views.size(), 24u);
  expect_better_than_neighbours("grid", views, left_out);
}

}  // namespace
}  // namespace wheatstone::testing
