#include "calib/eye_solver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "core/random.h"

namespace wheatstone {
namespace {

constexpr DisplayId kId = {Eye::kLeft, Plane::kFar};
const Intrinsics kTruth = {8830, 8825, 3, 1010, 780, 2048, 1536};
const Eigen::Vector3d kEye(153.5, 130, 850);

RigidTransform true_pose() {
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(0.02, Eigen::Vector3d(0.3, 1, 0.2).normalized()).toRotationMatrix() *
      straight_R_camera_rsb();
  return {R, -(R * kEye)};
}

std::vector<Alignment> marks(double noise_px = 0, std::uint64_t seed = 1) {
  RandomStream random(seed, 2);
  std::vector<Alignment> out;
  for (const auto& [dx, dy, z] : {std::array{38.0, 38.0, 360.0}, std::array{85.0, 62.0, 0.0}})
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3d p(185 + (i % 2 ? dx : -dx), 130 + (i / 2 ? dy : -dy), z);
      out.push_back({p, project(projection_matrix(kTruth.K(), true_pose()), p) +
                            noise_px * Eigen::Vector2d(random.normal(), random.normal())});
    }
  return out;
}

TEST(EyeSolver, ExactWithoutNoise) {
  const EyeDisplayCalibration c = solve_eye_display(kId, marks(), 2048, 1536);
  EXPECT_TRUE(c.id == kId);
  EXPECT_LT(c.rms_px, 1e-6);
  EXPECT_EQ(c.residuals_px.size(), 8u);
  EXPECT_LT((c.intrinsics.K() - kTruth.K()).norm(), 1e-2);
  EXPECT_EQ(c.intrinsics.width_px, 2048);
  EXPECT_LT((camera_centre(c.T_eye_rsb) - kEye).norm(), 1e-3);
  EXPECT_LT((c.T_eye_rsb.R - true_pose().R).norm(), 1e-5);
  EXPECT_NEAR(c.T_eye_rsb.R.determinant(), 1, 1e-9);
  EXPECT_LT((c.P_lcd_rsb - projection_matrix(c.intrinsics.K(), c.T_eye_rsb)).norm(), 1e-9);
}

TEST(EyeSolver, LcdRowsGoDown) {
  const auto P = solve_eye_display(kId, marks(), 2048, 1536).P_lcd_rsb;
  const Eigen::Vector3d low(185, 100, 100), high(185, 160, 100), right(200, 100, 100);
  EXPECT_GT(project(P, low).y(), project(P, high).y());
  EXPECT_GT(project(P, right).x(), project(P, low).x());
}

TEST(EyeSolver, NoisePropagatesToAboutOnePixelBetweenTheMarks) {
  double rms = 0, between = 0;
  const int seeds = 50;
  const Eigen::Vector3d p(190, 120, 180);
  for (int seed = 0; seed < seeds; ++seed) {
    const auto c = solve_eye_display(kId, marks(0.5, static_cast<std::uint64_t>(seed)), 2048, 1536);
    rms += c.rms_px * c.rms_px / seeds;
    between += (project(c.P_lcd_rsb, p) - project(projection_matrix(kTruth.K(), true_pose()), p))
                   .squaredNorm() /
               seeds;
  }
  // 16 equations, 11 unknowns: E[rms^2] = 2 sigma^2 5/16 over the marks.
  EXPECT_NEAR(std::sqrt(rms), 0.5 * std::sqrt(2.0 * 5 / 16), 0.1);
  EXPECT_LT(std::sqrt(between), 1.0);
}

void expect_refused(const std::vector<Alignment>& m, const std::string& part) {
  try {
    solve_eye_display(kId, m, 2048, 1536);
    FAIL() << "expected: " << part;
  } catch (const ArgumentError& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr(part));
  }
}

TEST(EyeSolver, DegenerateMarksAreRefusedWithTheRemedy) {
  auto five = marks();
  five.resize(5);
  expect_refused(five, "4 near crosses and 4 marker LEDs");

  auto plane = marks(0.5);
  for (std::size_t i = 0; i < 4; ++i) {
    plane[i].p_rsb_mm.z() = 0;
    plane[i].lcd_px = project(projection_matrix(kTruth.K(), true_pose()), plane[i].p_rsb_mm);
  }
  expect_refused(plane, "on one plane");

  auto tilted = marks();  // a plane that is not parallel to the axes
  for (auto& m : tilted) {
    m.p_rsb_mm.z() = 0.5 * m.p_rsb_mm.x() + 0.2 * m.p_rsb_mm.y();
    m.lcd_px = project(projection_matrix(kTruth.K(), true_pose()), m.p_rsb_mm);
  }
  expect_refused(tilted, "on one plane");

  // Five marks on one plane and one before it leave the projection open.
  auto six = marks();
  six = {six[4], six[5], six[6], six[7], {{185, 130, 0}, {}}, six[0]};
  six[4].lcd_px = project(projection_matrix(kTruth.K(), true_pose()), six[4].p_rsb_mm);
  expect_refused(six, "degenerate layout");
}

TEST(EyeSolver, MirroredLcdIsRefused) {
  auto m = marks();
  for (auto& a : m) a.lcd_px.x() = 2047 - a.lcd_px.x();
  expect_refused(m, "mirror image");
}

}  // namespace
}  // namespace wheatstone
