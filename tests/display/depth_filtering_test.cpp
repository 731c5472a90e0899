#include "display/depth_filtering.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>

#include "core/error.h"

namespace wheatstone {
namespace {

nlohmann::json vectors(const std::string& name) {
  std::ifstream in(std::string(WHEATSTONE_SOURCE_DIR "/tests/vectors/") + name);
  return nlohmann::json::parse(in).at("cases");
}

TEST(DepthFiltering, ReferenceVectors) {
  for (const auto& c : vectors("mf_linear.json")) {
    std::vector<Vergence> planes;
    for (const double d : c.at("planes_D")) planes.push_back(Vergence::of(d));
    const auto w = plane_weights(planes, Vergence::of(c.at("stimulus_D")));
    ASSERT_EQ(w.size(), c.at("weights").size());
    for (std::size_t i = 0; i < w.size(); ++i)
      EXPECT_NEAR(w[i], c["weights"][i].get<double>(), 1e-9);
  }
}

TEST(DepthFiltering, ExactPlanesOfTheRig) {
  const std::vector<Vergence> planes = {vergence_at(490.0_mm), vergence_at(850.0_mm)};
  EXPECT_NEAR(plane_weights(planes, vergence_at(550.0_mm))[0], 0.742424, 1e-6);
  EXPECT_NEAR(plane_weights(planes, vergence_at(600.0_mm))[0], 0.567130, 1e-6);
  EXPECT_NEAR(plane_weights(planes, vergence_at(700.0_mm))[0], 0.291667, 1e-6);
  EXPECT_EQ(plane_weights(planes, vergence_at(850.0_mm))[0], 0);
  EXPECT_EQ(plane_weights(planes, vergence_at(490.0_mm))[0], 1);
  double before = 0;
  for (double d = 1.0; d < 2.3; d += 0.001) {
    const auto w = plane_weights(planes, Vergence::of(d));
    EXPECT_DOUBLE_EQ(std::accumulate(w.begin(), w.end(), 0.0), 1);
    EXPECT_GE(w[0], before);           // monotone
    EXPECT_LE(w[0] - before, 0.0012);  // continuous
    before = w[0];
  }
}

TEST(DepthFiltering, BadPlanesAreRefused) {
  const Vergence ascending[] = {1.0_D, 2.0_D}, equal[] = {1.0_D, 1.0_D}, good[] = {2.0_D, 1.0_D};
  EXPECT_THROW(plane_weights({}, 1.0_D), ArgumentError);
  EXPECT_THROW(plane_weights(ascending, 1.0_D), ArgumentError);
  EXPECT_THROW(plane_weights(equal, 1.0_D), ArgumentError);
  EXPECT_THROW(plane_weights(good, Vergence::of(std::numeric_limits<double>::quiet_NaN())),
               ArgumentError);
}

TEST(DepthFiltering, MisalignmentVectors) {
  for (const auto& c : vectors("mf_misalign.json")) {
    const auto e = Length::of(c.at("eye_shift_mm")), near_plane = Length::of(c.at("near_mm")),
               far_plane = Length::of(c.at("far_mm"));
    const double shift = lateral_misalignment_rad(e, near_plane, far_plane);
    const double degrees = shift * 180 / std::numbers::pi;
    EXPECT_NEAR(shift, c.at("lateral_rel_shift_rad").get<double>(), 1e-9);
    EXPECT_NEAR(degrees * 60 / c.at("arcmin").get<double>(), 1, 1e-8);
    EXPECT_NEAR(degrees * 85 / c.at("near_pixels_85ppd").get<double>(), 1, 1e-8);
    const double growth = axial_relative_magnification(e, near_plane, far_plane);
    EXPECT_NEAR(growth, c.at("axial_same_mm_relative_magnification").get<double>(), 1e-9);
    EXPECT_NEAR(growth * 850, c.at("edge_px_at_10deg").get<double>(), 1e-6);
  }
}

TEST(DepthFiltering, PlanesAddUpToTheLight) {
  RgbImage light(5, 4);
  ScalarImage w(5, 4);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 5; ++x) {
      light.pixels(y, x) = {100.0f * x, 30.0f * y, 7};
      w.pixels(y, x) = 0.05f * (x + 4 * y);
    }
  const PlanePair pair = split_by_depth(light, w);
  const cv::Mat3f sum = pair.near_cd_m2.pixels + pair.far_cd_m2.pixels;
  EXPECT_LT(cv::norm(sum, light.pixels, cv::NORM_INF), 1e-4);
  EXPECT_EQ(cv::norm(weighted(light, 1.0).pixels, light.pixels, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(weighted(light, 0.0).pixels, cv::NORM_INF), 0);
  EXPECT_THROW(weighted(light, ScalarImage(4, 4)), ArgumentError);
  EXPECT_THROW(weighted(light, 1.1), ArgumentError);
  light.pixels(1, 1)[2] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(weighted(light, w), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
