#include "calib/markers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/random.h"

namespace wheatstone {
namespace {

CameraProfile camera() {
  CameraProfile p;
  p.black_dn = 512;
  p.white_dn = 16383;
  p.camera_from_bt709 = Eigen::Vector3d(0.55, 1.0, 0.7).asDiagonal();
  p.dn_per_electron = {0.42, 0.38, 0.39};
  p.read_noise_e = 0.7;
  p.adc_noise = 3;
  return p;
}

struct Disc {
  Eigen::Vector2d centre;
  double peak_dn;
};

/// Discs of 4 px diameter, each pixel integrated over its area on a 32 x 32 grid.
MosaicImage render(const std::vector<Disc>& discs, const Eigen::Vector3d& tint,
                   BayerPattern pattern, RandomStream* noise) {
  const CameraProfile p = camera();
  MosaicImage m{cv::Mat1w(120, 160), pattern};
  for (int r = 0; r < 120; ++r)
    for (int c = 0; c < 160; ++c) {
      const int colour = bayer_colour(pattern, r, c);
      double dn = 2;  // a little stray light
      for (const Disc& d : discs) {
        if ((d.centre - Eigen::Vector2d(c, r)).norm() > 4) continue;
        int inside = 0;
        for (int i = 0; i < 1024; ++i)
          inside += (Eigen::Vector2d(c - 0.5 + (i % 32 + 0.5) / 32, r - 0.5 + (i / 32 + 0.5) / 32) -
                     d.centre)
                        .norm() < 2;
        dn += d.peak_dn * inside / 1024;
      }
      dn *= (p.camera_from_bt709 * tint)[colour];
      if (noise) {
        const double k = p.dn_per_electron[static_cast<std::size_t>(colour)];
        dn = (noise->poisson(dn / k) + p.read_noise_e * noise->normal() +
              p.adc_noise * noise->normal()) *
             k;
      }
      m.dn(r, c) = static_cast<std::uint16_t>(std::clamp(std::round(dn) + 512, 0.0, 16383.0));
    }
  return m;
}

double worst_error(BayerPattern pattern, const Eigen::Vector3d& tint, bool noisy) {
  RandomStream random(7, static_cast<std::uint64_t>(pattern));
  double worst = 0;
  for (int trial = 0; trial < 10; ++trial) {
    std::vector<Disc> discs;
    for (int i = 0; i < 4; ++i)
      discs.push_back(
          {{30 + 90 * (i % 2) + 4 * random.uniform(), 30 + 50 * (i / 2) + 4 * random.uniform()},
           6000.0 - 500 * i});
    const auto blobs =
        find_markers(render(discs, tint, pattern, noisy ? &random : nullptr), camera());
    EXPECT_EQ(blobs.size(), 4u);
    for (std::size_t i = 0; i < std::min<std::size_t>(4, blobs.size()); ++i) {
      double nearest = 1e9;
      for (const Disc& d : discs)
        nearest = std::min(nearest, (blobs[i].centroid_px - d.centre).norm());
      worst = std::max(worst, nearest);
    }
  }
  return worst;
}

TEST(Markers, CentroidsAreUnbiasedForEveryPattern) {
  for (const auto pattern :
       {BayerPattern::kRggb, BayerPattern::kBggr, BayerPattern::kGrbg, BayerPattern::kGbrg}) {
    EXPECT_LT(worst_error(pattern, {1, 1, 1}, false), 0.015) << to_string(pattern);
    EXPECT_LT(worst_error(pattern, {1, 1, 1}, true), 0.03) << to_string(pattern);
    EXPECT_LT(worst_error(pattern, {0.93, 1, 1.07}, false), 0.03) << to_string(pattern);
  }
}

TEST(Markers, PredictedSigmaMatchesTheScatter) {
  RandomStream random(3, 1);
  double sum = 0, predicted = 0;
  const int trials = 100;
  for (int i = 0; i < trials; ++i) {
    const auto blobs = find_markers(
        render({{{80.3, 60.4}, 400}}, {1, 1, 1}, BayerPattern::kRggb, &random), camera());
    ASSERT_EQ(blobs.size(), 1u);
    sum += (blobs[0].centroid_px - Eigen::Vector2d(80.3, 60.4)).squaredNorm() / 2;
    predicted += std::sqrt(blobs[0].covariance_px2.trace() / 2) / trials;
  }
  EXPECT_NEAR(std::sqrt(sum / trials) / predicted, 1, 0.35);
}

TEST(Markers, DarkNoiseAndHotPixelsAreNoMarkers) {
  RandomStream random(5, 1);
  MosaicImage m = render({}, {1, 1, 1}, BayerPattern::kRggb, &random);
  m.dn(40, 41) = 9000;
  EXPECT_TRUE(find_markers(m, camera()).empty());
}

TEST(Markers, SortedBySignal) {
  const auto blobs = find_markers(render({{{30, 30}, 1000}, {{100, 30}, 5000}, {{60, 80}, 3000}},
                                         {1, 1, 1}, BayerPattern::kRggb, nullptr),
                                  camera());
  ASSERT_EQ(blobs.size(), 3u);
  EXPECT_NEAR(blobs[0].centroid_px.x(), 100, 0.1);
  EXPECT_NEAR(blobs[2].centroid_px.x(), 30, 0.1);
}

MarkerBlob at(double x, double y, double signal) {
  MarkerBlob b;
  b.centroid_px = {x, y};
  b.signal_dn = signal;
  return b;
}

TEST(Markers, OrderFollowsGeometryNotStrength) {
  const std::vector<MarkerBlob> blobs = {at(500, 80, 9), at(90, 420, 8), at(100, 100, 7),
                                         at(510, 400, 6), at(300, 300, 1)};
  const auto p = order_markers(blobs, "frame 3");
  EXPECT_EQ(p[0].centroid_px, Eigen::Vector2d(90, 420));
  EXPECT_EQ(p[1].centroid_px, Eigen::Vector2d(510, 400));
  EXPECT_EQ(p[2].centroid_px, Eigen::Vector2d(100, 100));
  EXPECT_EQ(p[3].centroid_px, Eigen::Vector2d(500, 80));
}

TEST(Markers, TooFewOrMisplacedMarkersAreNamed) {
  const std::vector<MarkerBlob> three = {at(0, 0, 3), at(9, 0, 2), at(0, 9, 1)};
  try {
    order_markers(three, "frame 3");
    FAIL();
  } catch (const ArgumentError& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("frame 3: found 3 of 4"));
  }
  const std::vector<MarkerBlob> line = {at(0, 0, 4), at(10, 0, 3), at(20, 0, 2), at(30, 0, 1)};
  EXPECT_THROW(order_markers(line, "frame 3"), ArgumentError);
  EXPECT_THROW(find_markers(MosaicImage{}, camera()), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
