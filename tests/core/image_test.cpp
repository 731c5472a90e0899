#include "core/image.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/error.h"

namespace wheatstone {
namespace {

TEST(Image, WhiteHasTheLuminanceOfItsComponents) {
  const RgbImage white(cv::Mat3f(2, 3, cv::Vec3f(250, 250, 250)));
  EXPECT_NEAR(luminance_cd_m2(white).pixels(1, 2), 250, 1e-3);
}

TEST(Image, EveryBayerCellHasOneRedTwoGreenOneBlue) {
  for (auto p :
       {BayerPattern::kRggb, BayerPattern::kBggr, BayerPattern::kGrbg, BayerPattern::kGbrg}) {
    int count[3] = {};
    for (int r = 0; r < 2; ++r)
      for (int c = 0; c < 2; ++c) ++count[bayer_colour(p, r, c)];
    EXPECT_EQ(count[0], 1);
    EXPECT_EQ(count[1], 2);
    EXPECT_EQ(count[2], 1);
    EXPECT_EQ(bayer_pattern_from_string(to_string(p)), p);
  }
  EXPECT_THROW(bayer_pattern_from_string("RGB"), ArgumentError);
}

TEST(Image, ImpossibleRadianceIsCountedAndLocated) {
  RgbImage image(4, 4);
  image.pixels(2, 1)[0] = -1;
  image.pixels(3, 3)[2] = std::numeric_limits<float>::quiet_NaN();
  image.pixels(3, 3)[1] = std::numeric_limits<float>::infinity();
  try {
    require_valid_radiance(image, "view_007");
    FAIL();
  } catch (const ArgumentError& e) {
    const std::string what = e.what();
    EXPECT_NE(what.find("view_007"), std::string::npos);
    EXPECT_NE(what.find("1 NaN, 1 infinite, 1 negative"), std::string::npos);
    EXPECT_NE(what.find("column 1, row 2"), std::string::npos);
  }
}

}  // namespace
}  // namespace wheatstone
