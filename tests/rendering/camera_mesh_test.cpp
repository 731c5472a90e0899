#include "rendering/light_field/camera_mesh.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/random.h"
#include "tests/rendering/synthetic_light_field.h"

namespace wheatstone::testing {
namespace {

std::vector<LightFieldView> cameras_at(const std::vector<Eigen::Vector3d>& centres) {
  std::vector<LightFieldView> views;
  for (const auto& c : centres) {
    views.emplace_back();
    views.back().T_camera_world = straight_pose(c);
  }
  return views;
}

/// Weighted mean of the cameras' positions.
Eigen::Vector2d interpolated_position(const CameraMesh& mesh, const Eigen::Vector2d& st) {
  const CellWeights w = mesh.weights_at(st);
  Eigen::Vector2d sum(0, 0);
  for (int k = 0; k < w.cell->camera_count; ++k)
    sum += w.weights[k] * mesh.positions_mm()[w.cell->cameras[k]];
  return sum;
}

TEST(CameraMesh, ANearStraightPathIsALine) {
  const auto views = cameras_at({{0, 0, 600}, {20, 1, 601}, {10, -1, 599}, {35, 0, 600}});
  const CameraMesh mesh(views);
  EXPECT_TRUE(mesh.is_line());
  EXPECT_EQ(mesh.cells().size(), 3u);
}

TEST(CameraMesh, WeightsAtACameraAreThatCameraAlone) {
  const auto views = painted_grid(4, 3, 25);
  const CameraMesh mesh(views);
  EXPECT_FALSE(mesh.is_line());
  for (std::size_t i = 0; i < views.size(); ++i) {
    const CellWeights w = mesh.weights_at(mesh.positions_mm()[i]);
    for (int k = 0; k < w.cell->camera_count; ++k)
      EXPECT_NEAR(w.weights[k], w.cell->cameras[k] == static_cast<int>(i) ? 1.0 : 0.0, 1e-9);
  }
}

TEST(CameraMesh, WeightsReproducePositionsInsideAndStaySaneOutside) {
  RandomStream random(11, 0);
  std::vector<Eigen::Vector3d> centres;
  for (int i = 0; i < 15; ++i)
    centres.emplace_back(100 * random.uniform(), 80 * random.uniform(), 600);
  for (const Eigen::Vector3d& corner :
       {Eigen::Vector3d(-5, -5, 600), {105, -5, 600}, {105, 85, 600}, {-5, 85, 600}})
    centres.push_back(corner);
  const CameraMesh mesh(cameras_at(centres));
  for (int i = 0; i < 200; ++i) {
    // A point between two cameras is inside the hull.
    const auto& a = mesh.positions_mm()[i % centres.size()];
    const auto& b = mesh.positions_mm()[(i * 7 + 3) % centres.size()];
    const Eigen::Vector2d st = a + (0.02 + 0.96 * random.uniform()) * (b - a);
    const Eigen::Vector2d back = interpolated_position(mesh, st);
    // Hull edges may lack a sliver, hence not exactly.
    EXPECT_NEAR((back - st).norm(), 0, 1.5) << st.transpose();
    const CellWeights far = mesh.weights_at(20 * st);
    double sum = 0;
    for (const double w : far.weights) {
      EXPECT_GE(w, 0);
      sum += w;
    }
    EXPECT_NEAR(sum, 1, 1e-12);
  }
}

TEST(CameraMesh, OutsideARailItsEndIsUsed) {
  const CameraMesh mesh(cameras_at({{0, 0, 600}, {20, 0, 600}, {40, 0, 600}}));
  for (const double sign : {-1.0, 1.0}) {
    const Eigen::Vector2d st(sign * 500, 3);
    const CellWeights w = mesh.weights_at(st);
    EXPECT_EQ(std::max(w.weights[0], w.weights[1]), 1);
    EXPECT_EQ(w.cell->cameras[w.weights[0] == 1 ? 0 : 1], mesh.nearest(st));
  }
}

TEST(CameraMesh, OneCameraOrTwinsAreEnough) {
  EXPECT_EQ(CameraMesh(cameras_at({{3, 4, 5}})).weights_at({7, 8}).weights[0], 1);
  EXPECT_EQ(CameraMesh(cameras_at({{3, 4, 5}, {3, 4, 5}})).cells().size(), 1u);
  EXPECT_THROW(CameraMesh(std::span<const LightFieldView>()), ArgumentError);
}

}  // namespace
}  // namespace wheatstone::testing
