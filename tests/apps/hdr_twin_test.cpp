// From raw exposures to light with its uncertainty, against the twin's own truth.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/demosaic.h"
#include "capture/lamp_drift.h"
#include "capture/merge.h"
#include "capture/radiance.h"
#include "sim/camera.h"
#include "sim/world.h"

namespace wheatstone {
namespace {

const Deadline kNever{Nanoseconds{std::int64_t{1} << 62}};
const std::vector<double> kExposures_s = {1 / 240.0, 1 / 60.0, 1 / 15.0};

MergedMosaic capture(SimulatedCamera& camera, MergeOptions options) {
  std::vector<RawExposure> stack;
  for (const double t : kExposures_s)
    stack.push_back({camera.expose(Duration::of(t), kNever).mosaic, Duration::of(t)});
  return merge_exposures(stack, options);
}

/// DN/s at ISO 100 that every photosite should read.
cv::Mat1f true_mosaic(SimulatedCamera& camera) {
  return camera.optical_image_cd_m2() * camera.profile().dn_per_cd_m2_s;
}

/// Means per colour of a block of a mosaic; empty where a colour varies by more than a third.
std::optional<Eigen::Vector3d> mean_of_even_block(const cv::Mat1f& mosaic, const cv::Rect& block) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), count = sum, least(1e30, 1e30, 1e30), most = sum;
  for (int r = block.y; r < block.br().y; ++r)
    for (int c = block.x; c < block.br().x; ++c) {
      const int k = bayer_colour(BayerPattern::kRggb, r, c);
      sum[k] += mosaic(r, c);
      ++count[k];
      least[k] = std::min<double>(least[k], mosaic(r, c));
      most[k] = std::max<double>(most[k], mosaic(r, c));
    }
  if ((most.array() > 4.0 / 3 * least.array()).any()) return std::nullopt;
  return sum.cwiseQuotient(count);
}

// Regions of 32 x 32 px of merged, demosaiced and colour corrected light.
TEST(HdrOnTheTwin, RadianceOfEvenRegions) {
  for (const char* scene : {"card", "objects"}) {
    World world(scene, 0.25, 3);
    world.light.led_drive = 1;
    SimulatedCamera camera(world, true);
    const CameraProfile& p = camera.profile();
    const MergedMosaic merged = capture(camera, merge_options(p));
    const RgbImage light = to_radiance(demosaic(merged.mosaic), p);
    const Eigen::Matrix3d bt709_from_camera = p.camera_from_bt709.inverse();
    const cv::Mat1f optical = camera.optical_image_cd_m2();
    int bright = 0, dark = 0;
    double worst_bright = 0, worst_dark = 0;
    for (int y = 0; y + 32 <= light.height(); y += 32)
      for (int x = 0; x + 32 <= light.width(); x += 32) {
        const cv::Rect block(x, y, 32, 32);
        const auto camera_cd_m2 = mean_of_even_block(optical, block);
        if (!camera_cd_m2 || cv::countNonZero(merged.flags(block) & (kSaturated | kUnderexposed)))
          continue;
        const Eigen::Vector3d truth = bt709_from_camera * *camera_cd_m2;
        const cv::Scalar measured = cv::mean(light.pixels(block));
        double error = 0;
        for (int k = 0; k < 3; ++k)
          error = std::max(error, std::abs(measured[k] - truth[k]) / truth.maxCoeff());
        const bool is_bright = truth.maxCoeff() > 10;
        ++(is_bright ? bright : dark);
        double& worst = is_bright ? worst_bright : worst_dark;
        worst = std::max(worst, error);
      }
    std::cout << scene << ": worst of " << bright << " bright regions " << worst_bright << ", of "
              << dark << " dark ones " << worst_dark << "\n";
    EXPECT_GT(bright, 50);
    EXPECT_LT(worst_bright, 0.01);
    EXPECT_GT(dark, 50);
    EXPECT_LT(worst_dark, 0.03);
  }
}

// The lamps drift by some per cent from view to view. The merge itself keeps the scale to 0.2 %;
// how well a patch of the back wall tells the drift is limited by the uneven light on it, of which
// each view's whole pixels take a slightly different part.
TEST(HdrOnTheTwin, ViewsAreOnOneScale) {
  World world("card", 0.15, 5);
  SimulatedCamera camera(world, true);
  const CameraProfile& p = camera.profile();
  const Eigen::Vector3d monitor_rsb_mm(185, 225, 0);
  std::vector<PatchReading> readings;
  std::vector<double> scales, drives;
  for (int view = 0; view < 11; ++view) {
    world.carriage_mm = kStageTravelMm / 10 * view;
    world.light.led_drive = 0.95 + 0.03 * std::cos(view);
    const MergedMosaic merged = capture(camera, merge_options(p));
    const Eigen::Vector2d at =
        project(p.intrinsics, p.distortion, true_T_camera_rsb(world.carriage_mm) * monitor_rsb_mm);
    const cv::Rect patch(static_cast<int>(at.x()) - 50, static_cast<int>(at.y()) - 25, 100, 50);
    readings.push_back(read_monitor_patch(merged, patch));
    const cv::Mat1f truth = true_mosaic(camera);
    const cv::Mat1b well_exposed =
        (truth > 5 * p.dn_per_cd_m2_s) & ((merged.flags & kSaturated) == 0);
    drives.push_back(world.light.led_drive);
    scales.push_back(cv::mean(merged.mosaic.values, well_exposed)[0] /
                     cv::mean(truth, well_exposed)[0]);
  }
  const auto spread = [](const std::vector<double>& v) {
    const auto [least, most] = std::minmax_element(v.begin(), v.end());
    return *most / *least - 1;
  };
  EXPECT_GT(spread(drives), 0.05);
  std::vector<double> corrected;
  for (std::size_t i = 0; i < scales.size(); ++i)
    corrected.push_back(scales[i] * drives[i] * lamp_correction(readings[0], readings[i]).factor);
  std::cout << "view-to-view spread " << spread(scales) << ", with drift corrected "
            << spread(corrected) << "\n";
  EXPECT_LT(spread(scales), 0.002);
  EXPECT_LT(spread(corrected), 0.003);
}

// 95 % intervals over 200 seeded runs, for photosites that are well exposed by the truth.
TEST(HdrOnTheTwin, IntervalsContainTheTruth) {
  World world("objects", 0.02, 1);
  world.light.led_drive = 1;
  SimulatedCamera camera(world, true);
  const CameraProfile& p = camera.profile();
  const cv::Mat1f truth = true_mosaic(camera);
  for (const MergeEstimator estimator : {MergeEstimator::kPoisson, MergeEstimator::kFullNoise}) {
    MergeOptions options = merge_options(p);
    options.estimator = estimator;
    double bright = 0, dark = 0, bright_inside = 0, dark_inside = 0;
    for (world.seed = 1; world.seed <= 200; ++world.seed) {
      const MergedMosaic merged = capture(camera, options);
      for (int r = 0; r < truth.rows; ++r)
        for (int c = 0; c < truth.cols; ++c) {
          const double phi = truth(r, c);
          if (phi * kExposures_s.front() > 15000 || phi * kExposures_s.back() < 20) continue;
          const bool inside =
              std::abs(merged.mosaic.values(r, c) - phi) <= 1.959964 * merged.sigma_dn_s(r, c);
          const bool is_bright = phi > 10 * p.dn_per_cd_m2_s;
          ++(is_bright ? bright : dark);
          (is_bright ? bright_inside : dark_inside) += inside;
        }
    }
    ASSERT_GT(bright, 2e5);
    ASSERT_GT(dark, 2e5);
    std::cout << to_string(estimator) << ": bright " << bright_inside / bright << ", dark "
              << dark_inside / dark << "\n";
    for (const double share : {bright_inside / bright, dark_inside / dark}) {
      EXPECT_GT(share, 0.92) << to_string(estimator);
      EXPECT_LT(share, 0.98) << to_string(estimator);
    }
  }
}

/// Colour peak signal-to-noise ratio over the three colours, peak 65535, 8 px inside.
double cpsnr_db(const cv::Mat3f& a, const cv::Mat3f& b) {
  const cv::Rect inside(8, 8, b.cols - 16, b.rows - 16);
  const double squares = cv::norm(a(inside), b(inside), cv::NORM_L2SQR);
  return 10 * std::log10(65535.0 * 65535.0 * 3 * inside.area() / squares);
}

// All three colours of the lens's picture, by four sensors that differ in their pattern. Not on the
// scene "card": its smooth waves run against each other in red and blue, and without edges or
// common detail any method that expects the colours to vary together loses to plain interpolation.
TEST(HdrOnTheTwin, DemosaicingBeatsTheEdgeAwareMethod) {
  for (const char* scene : {"objects", "sphere"}) {
    World world(scene, 0.15, 3);
    world.light.led_drive = 1;
    cv::Mat3f truth;
    cv::Mat1w mosaic;
    for (const BayerPattern pattern :
         {BayerPattern::kBggr, BayerPattern::kGrbg, BayerPattern::kGbrg, BayerPattern::kRggb}) {
      world.camera_profile.pattern = pattern;
      const cv::Mat1f optical = SimulatedCamera(world, false).optical_image_cd_m2();
      truth.create(optical.size());
      mosaic.create(optical.size());
      for (int r = 0; r < optical.rows; ++r)
        for (int c = 0; c < optical.cols; ++c) {
          mosaic(r, c) = cv::saturate_cast<ushort>(65535.0 / 500 * optical(r, c));
          truth(r, c)[bayer_colour(pattern, r, c)] = mosaic(r, c);
        }
    }
    LinearMosaic linear{{}, BayerPattern::kRggb};
    mosaic.convertTo(linear.values, CV_32F);
    cv::Mat edge_aware;
    cv::demosaicing(mosaic, edge_aware, cv::COLOR_BayerBG2RGB_EA);
    edge_aware.convertTo(edge_aware, CV_32F);
    const double ours_db = cpsnr_db(demosaic(linear), truth);
    const double gain_db = ours_db - cpsnr_db(edge_aware, truth);
    std::cout << scene << ": " << ours_db << " dB, " << gain_db << " dB above edge-aware\n";
    EXPECT_GT(gain_db, 1.5);
  }
}

}  // namespace
}  // namespace wheatstone
