#include "calib/pose_solver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calib/marker_matching.h"
#include "calib/rail.h"
#include "core/random.h"
#include "tests/error_text.h"

namespace wheatstone {
namespace {

const std::vector<Eigen::Vector3d> kMarkers = {
    {100, 68, 0}, {270, 68, 0}, {100, 192, 0}, {270, 192, 0}};
const Intrinsics kCamera = {2811, 2811, 0, 1000, 750, 2000, 1500};
constexpr double kSigmaPx = 0.03;
const Distortion kLens = {-0.08, 0.05, 0.0005, -0.0003, 0};

struct Rail {
  std::vector<RigidTransform> poses;
  std::vector<std::vector<MarkerSighting>> seen;
};

Rail make_rail(int views, double noise_px, std::uint64_t seed, double turn_step = 0) {
  RandomStream random(seed, 1);
  Rail rail;
  for (int v = 0; v < views; ++v) {
    const Eigen::Matrix3d R = (Eigen::AngleAxisd(0.01 + turn_step * v, Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(-0.02, Eigen::Vector3d::UnitX()))
                                  .toRotationMatrix() *
                              straight_R_camera_rsb();
    const Eigen::Vector3d centre(155 + 6.0 * v, 130, 550);
    rail.poses.push_back({R, -(R * centre)});
    rail.seen.emplace_back();
    for (const auto& p : kMarkers)
      rail.seen.back().push_back({project(kCamera, kLens, rail.poses.back() * p) +
                                      noise_px * Eigen::Vector2d(random.normal(), random.normal()),
                                  kSigmaPx * kSigmaPx * Eigen::Matrix2d::Identity()});
  }
  return rail;
}

TEST(PoseSolver, ExactWithoutNoise) {
  const Rail rail = make_rail(5, 0, 1);
  const PoseSolution s = solve_poses(kMarkers, rail.seen, kCamera, kLens);
  EXPECT_LT(s.rms_px, 1e-6);
  for (std::size_t v = 0; v < 5; ++v) {
    EXPECT_LT((camera_centre(s.T_camera_rsb[v]) - camera_centre(rail.poses[v])).norm(), 1e-4);
    EXPECT_LT((s.T_camera_rsb[v].R - rail.poses[v].R).norm(), 1e-7);
  }
}

TEST(PoseSolver, CentresWithinATenthOfAMillimetre) {
  double sum = 0, expected = 0, worst = 0;
  const int seeds = 60;
  for (int seed = 0; seed < seeds; ++seed) {
    const Rail rail = make_rail(11, 0.03, 100 + static_cast<std::uint64_t>(seed));
    const PoseSolution s = solve_poses(kMarkers, rail.seen, kCamera, kLens);
    double seed_sum = 0;
    for (std::size_t v = 0; v < 11; ++v) {
      seed_sum += (camera_centre(s.T_camera_rsb[v]) - camera_centre(rail.poses[v])).squaredNorm();
      expected += s.centre_covariance_mm2(v).trace() / (11 * seeds);
    }
    worst = std::max(worst, std::sqrt(seed_sum / 11));
    sum += seed_sum / (11 * seeds);
  }
  RecordProperty("centre_rms_um", static_cast<int>(1000 * std::sqrt(sum)));
  RecordProperty("worst_seed_um", static_cast<int>(1000 * worst));
  EXPECT_LT(std::sqrt(sum), 0.1);
  // Nearly all of it is the shared rotation, one draw per seed: single seeds scatter widely.
  EXPECT_LT(worst, 0.2);
  EXPECT_NEAR(std::sqrt(sum / expected), 1, 0.3) << "covariance against scatter";
}

TEST(PoseSolver, MarkersOffTheWallInAnyOrder) {
  std::vector<Eigen::Vector3d> markers = kMarkers;
  for (Eigen::Vector3d& p : markers) p.z() = 0.2;
  const RigidTransform T = make_rail(1, 0, 1).poses[0];
  std::sort(markers.begin(), markers.end(), [](auto& a, auto& b) { return a.x() < b.x(); });
  for (const int first : {0, 1, 2, 3}) {
    std::rotate(markers.begin(), markers.begin() + first, markers.end());
    std::vector<std::vector<MarkerSighting>> seen(1);
    for (const auto& p : markers)
      seen[0].push_back(
          {project(kCamera, kLens, T * p), kSigmaPx * kSigmaPx * Eigen::Matrix2d::Identity()});
    const PoseSolution s = solve_poses(markers, seen, kCamera, kLens);
    EXPECT_LT((camera_centre(s.T_camera_rsb[0]) - camera_centre(T)).norm(), 1e-4) << first;
    std::swap(markers[0], markers[2]);  // the other way round
  }
}

TEST(PoseSolver, FreeRotationsTellWhenTheCarriageTurns) {
  const Rail rail = make_rail(7, 0.03, 9, 0.002);
  const PoseSolution shared = solve_poses(kMarkers, rail.seen, kCamera, kLens);
  EXPECT_GT(shared.rms_px, 5 * shared.rms_free_px);
  const PoseSolution free = solve_poses(kMarkers, rail.seen, kCamera, kLens, {false});
  EXPECT_LT(free.rms_px, 0.06);
  EXPECT_EQ(free.rms_px, free.rms_free_px);
  EXPECT_THAT(free.report, testing::HasSubstr("7 poses"));
}

// More rotations always lessen the residuals, which says nothing; per degree of freedom only a
// carriage that turns does.
TEST(PoseSolver, PerDegreeOfFreedomTellsTurnsFromFreedom) {
  double ratio = 0, bare = 0;
  const int runs = 40;
  for (int run = 0; run < runs; ++run) {
    const PoseSolution s = solve_poses(
        kMarkers, make_rail(7, 0.03, 700 + static_cast<std::uint64_t>(run)).seen, kCamera, kLens);
    ratio += s.scatter_free_px / s.scatter_px / runs;
    bare += s.rms_free_px / s.rms_px / runs;
    EXPECT_NEAR(s.scatter_px, 0.03, 0.012);
  }
  EXPECT_NEAR(ratio, 1, 0.08);
  EXPECT_LT(bare, 0.75);
  const PoseSolution turning =
      solve_poses(kMarkers, make_rail(7, 0.03, 9, 0.002).seen, kCamera, kLens);
  EXPECT_GT(turning.scatter_px, 5 * turning.scatter_free_px);
}

/// Sightings whose noise has a covariance of its own, told to the solver up to a common factor.
Rail make_uneven_rail(int views, std::uint64_t seed) {
  Rail rail = make_rail(views, 0, seed);
  RandomStream random(seed, 2);
  for (auto& view : rail.seen)
    for (MarkerSighting& m : view) {
      const double a = 0.005 + 0.02 * random.uniform(), b = 0.005 + 0.02 * random.uniform();
      const Eigen::Matrix2d turn = Eigen::Rotation2Dd(3 * random.uniform()).toRotationMatrix();
      m.px += turn * Eigen::Vector2d(a * random.normal(), b * random.normal());
      m.covariance_px2 =
          0.25 * turn * Eigen::Vector2d(a * a, b * b).asDiagonal() * turn.transpose();
    }
  return rail;
}

// All six parameters of the first and the last pose, with and without the rail prior. The told
// covariances are four times too small: the residuals must set that right. 600 runs, because the
// percentage of 200 scatters by 1.5.
TEST(PoseSolver, IntervalsContainTheTruth) {
  const int runs = 600;
  for (const bool rail_prior : {true, false}) {
    int inside[6] = {};
    double factor = 0;
    for (int run = 0; run < runs; ++run) {
      const Rail rail = make_uneven_rail(4, 500 + static_cast<std::uint64_t>(run));
      const PoseSolution s = solve_poses(kMarkers, rail.seen, kCamera, kLens, {rail_prior});
      factor += s.noise_factor / runs;
      for (const std::size_t v : {std::size_t{0}, std::size_t{3}}) {
        const Eigen::AngleAxisd turn(s.T_camera_rsb[v].R * rail.poses[v].R.transpose());
        Eigen::Matrix<double, 6, 1> error;
        error << turn.angle() * turn.axis(),
            camera_centre(s.T_camera_rsb[v]) - camera_centre(rail.poses[v]);
        for (int i = 0; i < 6; ++i)
          inside[i] += std::abs(error[i]) < 1.96 * std::sqrt(s.covariance[v](i, i));
      }
    }
    EXPECT_GT(factor, 1.9);  // 2, and what Student's t adds for 17 and 8 degrees of freedom
    EXPECT_LT(factor, 2.4);
    for (int i = 0; i < 6; ++i) {
      const double percent = 50.0 * inside[i] / runs;
      RecordProperty((rail_prior ? "rail_percent_" : "free_percent_") + std::to_string(i),
                     std::to_string(percent));
      EXPECT_GE(percent, 92) << rail_prior << i;
      EXPECT_LE(percent, 98) << rail_prior << i;
    }
  }
}

// Of a plane's two poses the wrong one may start a view, and nothing must come of it.
TEST(PoseSolver, LongRailsAlwaysHaveACovariance) {
  for (std::uint64_t seed = 10300; seed < 10420; ++seed) {
    const PoseSolution s =
        solve_poses(kMarkers, make_uneven_rail(11, seed).seen, kCamera, kLens, {true});
    EXPECT_GT(s.covariance[10].diagonal().minCoeff(), 0) << seed;
    EXPECT_LT(s.rms_px, 0.05) << seed;
  }
}

TEST(PoseSolver, TheRailPriorHelpsAndDoesNotHideABend) {
  Rail rail = make_rail(7, 0.3, 4);  // poor sightings: 0.3 px
  for (auto& view : rail.seen)
    for (MarkerSighting& m : view) m.covariance_px2 *= 100;
  const auto z_sigma = [](const PoseSolution& s) { return std::sqrt(s.covariance[3](5, 5)); };
  const PoseSolution tight = solve_poses(kMarkers, rail.seen, kCamera, kLens, {true, 0.01});
  const PoseSolution wide = solve_poses(kMarkers, rail.seen, kCamera, kLens, {true, 10});
  EXPECT_LT(z_sigma(tight), 0.8 * z_sigma(wide));
  EXPECT_THROW(solve_poses(kMarkers, rail.seen, kCamera, kLens, {true, 0}), ArgumentError);

  // A bend of 0.2 mm in the middle: the free centres show it.
  Rail bent = make_rail(7, 0, 4);
  const Eigen::Vector3d moved = camera_centre(bent.poses[3]) + Eigen::Vector3d(0, 0.2, 0);
  bent.poses[3].t_mm = -(bent.poses[3].R * moved);
  for (std::size_t m = 0; m < kMarkers.size(); ++m)
    bent.seen[3][m].px = project(kCamera, kLens, bent.poses[3] * kMarkers[m]);
  const PoseSolution s = solve_poses(kMarkers, bent.seen, kCamera, kLens);
  EXPECT_NEAR(s.free_centres_rsb[3].y(), 130.2, 1e-3);
  EXPECT_NEAR(camera_centre(s.T_camera_rsb[3]).y(), 130.2, 0.02);
}

TEST(PoseSolver, PlaneUncertaintyIsWhatTheCovarianceProjectsTo) {
  const Rail rail = make_rail(3, 0, 1);
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  covariance(3, 3) = 0.01;  // 0.1 mm along x: 2811 px / 190 mm times that, nearly
  EXPECT_NEAR(plane_uncertainty_px(rail.poses[0], covariance, kCamera, Distortion{}, 360,
                                   {150, 125}, {160, 135}),
              2811 * 0.1 / 190, 0.05);
  EXPECT_THROW(
      plane_uncertainty_px(rail.poses[0], covariance, kCamera, kLens, 900, {75, 25}, {295, 235}),
      ArgumentError);
}

MarkerBlob blob(const Eigen::Vector2d& px, double signal) {
  MarkerBlob b;
  b.centroid_px = px;
  b.signal_dn = signal;
  return b;
}

std::string mismatch(const std::vector<MarkerBlob>& blobs,
                     const std::vector<Eigen::Vector3d>& markers) {
  return error_of([&] { match_markers(blobs, markers, kCamera, kLens, "frame 3"); });
}

TEST(MarkerMatching, ReflectionsAreLeftAside) {
  const Rail rail = make_rail(3, 0, 1);
  std::vector<MarkerBlob> blobs;
  for (std::size_t m = 0; m < 4; ++m) blobs.push_back(blob(rail.seen[1][m].px, 1000 + 10.0 * m));
  blobs.push_back(blob({300, 300}, 5000));  // brighter than any marker
  blobs.push_back(blob({700, 900}, 4000));
  const auto found = match_markers(blobs, kMarkers, kCamera, kLens, "frame 3");
  for (std::size_t m = 0; m < 4; ++m) EXPECT_EQ(found[m].centroid_px, rail.seen[1][m].px);
}

TEST(MarkerMatching, SwappedAndMissingLedsAreNamed) {
  const Rail rail = make_rail(3, 0, 1);
  std::vector<MarkerBlob> blobs;
  for (std::size_t m = 0; m < 4; ++m) blobs.push_back(blob(rail.seen[1][m].px, 1000));
  std::vector<Eigen::Vector3d> swapped = kMarkers;
  std::swap(swapped[1], swapped[3]);
  EXPECT_THAT(mismatch(blobs, swapped),
              testing::HasSubstr("frame 3: the bottom-right and top-right LEDs are swapped"));
  blobs[2].centroid_px += Eigen::Vector2d(120, -60);  // a reflection in its stead
  EXPECT_THAT(mismatch(blobs, kMarkers),
              testing::HasSubstr("frame 3: the top-left LED is missing or hidden"));
  blobs[0].centroid_px += Eigen::Vector2d(-50, -80);
  EXPECT_THAT(mismatch(blobs, kMarkers), testing::HasSubstr("no four spots stand where"));
  blobs.pop_back();
  EXPECT_THAT(mismatch(blobs, kMarkers), testing::HasSubstr("found 3 of 4"));
}

TEST(Rail, WorkedNumbers) {
  const std::vector<Eigen::Vector3d> centres = {
      {0, 0, 0}, {10.1, 0.1, 0}, {19.9, -0.1, 0}, {30, 0, 0}};
  const RailReport r = report_rail(centres, std::vector<double>{0, 10, 20, 30});
  EXPECT_NEAR(r.direction_rsb.x(), 1, 1e-4);
  EXPECT_NEAR(r.pitch_mm, 10, 1e-3);
  EXPECT_NEAR(r.scale, 0.998, 1e-3);
  EXPECT_NEAR(r.straightness_largest_mm, 0.1, 0.02);
  EXPECT_NEAR(r.step_error_largest_mm, 0.1, 0.03);
  EXPECT_NEAR(r.off_line_mm[1].y(), 0.1, 0.02);
  EXPECT_NEAR(r.off_line_mm[2].y(), -0.1, 0.02);
  EXPECT_NEAR(r.step_error_mm[1], 0.1, 0.03);
  EXPECT_NEAR(r.step_error_mm[2], -0.1, 0.03);
  const RailReport back = report_rail(centres, std::vector<double>{30, 20, 10, 0});
  EXPECT_NEAR(back.direction_rsb.x(), -1, 1e-4);
  EXPECT_THROW(report_rail(centres, std::vector<double>{1, 2}), ArgumentError);
  EXPECT_THROW(report_rail(centres, std::vector<double>{1, 1, 1, 1}), ArgumentError);
}

// Whatever the rail's scale, offset and direction, and however many views a minority is.
TEST(Rail, MisplacedViewsAreFound) {
  RandomStream random(11, 3);
  for (const double scale : {1.0, 0.93, -1.02, 25.4}) {
    std::vector<double> positions;
    std::vector<Eigen::Vector3d> centres;
    for (int v = 0; v < 9; ++v) {
      positions.push_back(40 + 7.0 * v);
      centres.push_back(Eigen::Vector3d(300, 130, 550) +
                        scale * positions.back() * Eigen::Vector3d(1, 0.02, -0.01).normalized() +
                        0.05 * Eigen::Vector3d(random.normal(), random.normal(), random.normal()));
    }
    EXPECT_TRUE(misplaced_views(centres, positions, 1).empty()) << scale;
    std::vector<Eigen::Vector3d> wrong = centres;
    wrong[4] = centres[0];
    wrong[7] = centres[8];
    wrong[2] = centres[3];
    const auto found = misplaced_views(wrong, positions, 1);
    ASSERT_EQ(found.size(), 3u) << scale;
    const std::size_t views[] = {2, 4, 7};
    const double seen[] = {61, 40, 96};
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(found[i].view, views[i]);
      EXPECT_NEAR(found[i].seen_mm, seen[i], 0.5);
      EXPECT_EQ(found[i].reported_mm, positions[views[i]]);
    }
  }
  // Half a millimetre is the encoder's own affair.
  std::vector<Eigen::Vector3d> centres = {{0, 0, 0}, {10, 0, 0}, {20.5, 0, 0}, {30, 0, 0}};
  const std::vector<double> positions = {0, 10, 20, 30};
  EXPECT_TRUE(misplaced_views(centres, positions, 1).empty());
  centres[3] = centres[1];
  centres[2] = centres[0];
  EXPECT_THAT(error_of([&] { misplaced_views(centres, positions, 1); }),
              testing::HasSubstr("no majority"));
  std::fill(centres.begin(), centres.end(), centres[0]);
  EXPECT_THAT(error_of([&] { misplaced_views(centres, positions, 1); }),
              testing::HasSubstr("stays in one place"));
  EXPECT_TRUE(misplaced_views(centres, std::vector<double>(4, 5.0), 1).empty());
  EXPECT_THROW(misplaced_views(centres, std::vector<double>{1, 2}, 1), ArgumentError);
}

TEST(PoseSolver, BadInputIsRefusedByView) {
  Rail rail = make_rail(3, 0, 1);
  EXPECT_THROW(solve_poses(kMarkers, {}, kCamera, kLens), ArgumentError);
  rail.seen[2].pop_back();
  try {
    solve_poses(kMarkers, rail.seen, kCamera, kLens);
    FAIL();
  } catch (const ArgumentError& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("view 2: 3 points"));
  }
  const std::vector<Eigen::Vector3d> line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  EXPECT_THROW(solve_poses(line, make_rail(1, 0, 1).seen, kCamera, kLens), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
