#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "core/error.h"
#include "rendering/metrics/hdrvdp3.h"

namespace wheatstone {
namespace {

RgbImage grey(int width, int height, float light_cd_m2 = 10) {
  RgbImage image(width, height);
  image.pixels.setTo(cv::Scalar::all(light_cd_m2));
  return image;
}

/// What the refusal says; empty when there is none.
std::string refusal(const RgbImage& test, const RgbImage& reference,
                    HdrVdp3Options options = {45}) {
  try {
    hdr_vdp3(test, reference, options);
  } catch (const ArgumentError& e) {
    return e.what();
  }
  return "";
}

using testing::AllOf;
using testing::HasSubstr;

TEST(HdrVdp3BadInput, SizesThatDiffer) {
  EXPECT_THAT(refusal(grey(30, 20), grey(20, 30)),
              AllOf(HasSubstr("30x20"), HasSubstr("20x30"), HasSubstr("; compare")));
  EXPECT_THAT(refusal(grey(30, 20), RgbImage()), HasSubstr("0x0"));
}

TEST(HdrVdp3BadInput, ImagesBelowTheFilters) {
  EXPECT_THAT(refusal(grey(12, 40), grey(12, 40)), HasSubstr("at least 13x13"));
  EXPECT_THAT(refusal(grey(40, 12), grey(40, 12)), HasSubstr("at least 13x13"));
  EXPECT_THAT(refusal(RgbImage(), RgbImage()), HasSubstr("too small"));
  EXPECT_EQ(refusal(grey(13, 13), grey(13, 13)), "");
}

TEST(HdrVdp3BadInput, ImpossibleLight) {
  for (const float bad :
       {-1.0f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    RgbImage image = grey(20, 20);
    image.pixels(4, 5)[1] = bad;
    EXPECT_THAT(refusal(image, grey(20, 20)),
                AllOf(HasSubstr("the test image"), HasSubstr("column 5, row 4")));
    EXPECT_THAT(refusal(grey(20, 20), image), HasSubstr("the reference image"));
  }
}

TEST(HdrVdp3BadInput, NoLightAtAll) {
  EXPECT_THAT(refusal(grey(20, 20, 0), grey(20, 20)),
              AllOf(HasSubstr("the test image is black"), HasSubstr("cd/m^2")));
  EXPECT_THAT(refusal(grey(20, 20), grey(20, 20, 0)), HasSubstr("the reference image is black"));
}

TEST(HdrVdp3BadInput, PixelsPerDegree) {
  for (const double bad : {0.0, -45.0, 3.99, 401.0, std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity()})
    EXPECT_THAT(refusal(grey(20, 20), grey(20, 20), {bad}), HasSubstr("pixels per degree"));
  EXPECT_THAT(refusal(grey(20, 20), grey(20, 20), HdrVdp3Options{}), HasSubstr("0 pixels"));
}

TEST(HdrVdp3BadInput, OtherAges) {
  for (const double age : {28.0, 60.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THAT(refusal(grey(20, 20), grey(20, 20), {45, age}), HasSubstr("use age 24"));
}

}  // namespace
}  // namespace wheatstone
