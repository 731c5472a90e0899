#include "calib/colour_calibration.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace wheatstone {
namespace {

Eigen::Vector3d vector3(const nlohmann::json& v) {
  return Eigen::Vector3d(v[0].get<double>(), v[1].get<double>(), v[2].get<double>());
}

TEST(ColourCalibration, ReferenceVectors) {
  std::ifstream file(WHEATSTONE_SOURCE_DIR "/tests/vectors/hdr/colour.json");
  ASSERT_TRUE(file);
  const auto json = nlohmann::json::parse(file);
  EXPECT_EQ(json["calibration"].size(), 2u);
  for (const auto& v : json["calibration"]) {
    std::vector<ChartPatch> patches;
    for (std::size_t i = 0; i < v["camera_rgb"].size(); ++i)
      patches.push_back({vector3(v["camera_rgb"][i]), vector3(v["reference_rgb"][i])});
    for (const auto& [key, weighting] :
         {std::pair("least_squares_matrix", ChartWeighting::kNone),
          std::pair("relative_weighted_matrix", ChartWeighting::kRelative)}) {
      const Eigen::Matrix3d M = fit_colour_matrix(patches, weighting);
      for (int r = 0; r < 3; ++r)
        // The vectors' colours have eight digits.
        EXPECT_LT((M.row(r).transpose() - vector3(v[key][r])).cwiseAbs().maxCoeff(), 1e-6) << key;
    }
  }
}

TEST(ColourCalibration, TheProfileInvertsTheMatrix) {
  Eigen::Matrix3d camera_from_light;
  camera_from_light << 700, 200, 50, 90, 800, 110, 20, 160, 750;
  std::vector<ChartPatch> patches;
  for (const Eigen::Vector3d& light :
       std::vector<Eigen::Vector3d>{{90, 10, 5}, {8, 80, 9}, {3, 7, 60}, {50, 50, 50}})
    patches.push_back({camera_from_light * light, light});
  const Eigen::Matrix3d M = fit_colour_matrix(patches, ChartWeighting::kRelative);
  CameraProfile camera;
  set_colour_response(camera, M);
  EXPECT_LT(
      (camera.dn_per_cd_m2_s * camera.camera_from_bt709 - camera_from_light).cwiseAbs().maxCoeff(),
      1e-8);
  EXPECT_NEAR(camera.camera_from_bt709.rowwise().sum().mean(), 1, 1e-12);

  // A reference patch measured 3 % brighter than the chart says moves the scale, not the colours.
  const ChartPatch grey = {patches[3].camera_rgb, 1.03 * patches[3].reference};
  EXPECT_LT((scaled_to_patch(M, grey) - 1.03 * M).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(ColourCalibration, WhatDeterminesNothingIsRefused) {
  const ChartPatch a{{1, 0, 0}, {1, 2, 3}}, b{{0, 1, 0}, {1, 2, 3}}, c{{1, 1, 0}, {1, 2, 3}};
  EXPECT_THROW(fit_colour_matrix({a, b}, ChartWeighting::kNone), ArgumentError);
  EXPECT_THROW(fit_colour_matrix({a, b, c}, ChartWeighting::kNone), ArgumentError);
  const ChartPatch dark{{0, 0, 1}, {0, 0, 0}};
  EXPECT_THROW(fit_colour_matrix({a, b, dark}, ChartWeighting::kRelative), ArgumentError);
  const ChartPatch lost{{0, 0, std::nan("")}, {1, 1, 1}};
  EXPECT_THROW(fit_colour_matrix({a, b, lost}, ChartWeighting::kNone), ArgumentError);
  EXPECT_THROW(scaled_to_patch(Eigen::Matrix3d::Identity(), dark), ArgumentError);
  CameraProfile camera;
  EXPECT_THROW(set_colour_response(camera, Eigen::Matrix3d::Zero()), ArgumentError);
  EXPECT_THROW(set_colour_response(camera, -Eigen::Matrix3d::Identity()), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
