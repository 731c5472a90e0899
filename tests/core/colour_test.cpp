#include "core/colour.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/image.h"

namespace wheatstone {
namespace {

TEST(Colour, MatricesOfTheReference) {
  std::ifstream file(WHEATSTONE_SOURCE_DIR "/tests/vectors/hdr/colour.json");
  ASSERT_TRUE(file);
  const auto json = nlohmann::json::parse(file);
  for (const auto& [name, primaries] :
       {std::pair("Rec709", bt709_primaries()), std::pair("Rec2020", bt2020_primaries()),
        std::pair("DisplayP3", display_p3_primaries())}) {
    const Eigen::Matrix3d M = xyz_from_rgb(primaries), inverse = M.inverse();
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(M(r, c), json["rgb_to_xyz"][name][r][c].get<double>(), 1e-9) << name;
        EXPECT_NEAR(inverse(r, c), json["xyz_to_rgb"][name][r][c].get<double>(), 2e-9) << name;
      }
  }
}

TEST(Colour, LuminanceWeightsAreThoseOfBt709) {
  const Eigen::Matrix3d M = xyz_from_rgb(bt709_primaries());
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(M(1, c), kLuminanceWeights[static_cast<std::size_t>(c)], 2e-5);
}

TEST(Colour, ImpossiblePrimariesAreRefused) {
  RgbPrimaries p = bt709_primaries();
  p.green_xy = (p.red_xy + p.blue_xy) / 2;
  EXPECT_THROW(xyz_from_rgb(p), ArgumentError);
  p = bt709_primaries();
  p.white_xy = {0.7, 0.25};
  EXPECT_THROW(xyz_from_rgb(p), ArgumentError);
  EXPECT_THROW(xyz_from_xyY({0.3, 0}, 1), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
