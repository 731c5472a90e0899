#include "rendering/motion_quality/gl/coarse_shading.h"

#include <gtest/gtest.h>

#include <set>

#include "core/error.h"
#include "tests/rendering/motion_quality/gl/random_maps.h"

namespace wheatstone::testing {
namespace {

TEST(CoarseShading, ShadingPointsAreBlockCentres) {
  EXPECT_EQ(shading_point(kShadingRates[0], 0, 0), cv::Point2d(1.5, 1.5));
  EXPECT_EQ(shading_point(kShadingRates[0], 7, 4), cv::Point2d(5.5, 5.5));
  EXPECT_EQ(shading_point(kShadingRates[1], 3, 3), cv::Point2d(2.5, 1.5));  // 2 wide, 4 high
  EXPECT_EQ(shading_point(kShadingRates[6], 5, 9), cv::Point2d(5, 9));
}

TEST(CoarseShading, ShadesAsOftenAsTheMapCosts) {
  const ShadingRateMap map = random_map(5, 4, 1);
  const CoarseShading out = shade_coarsely(
      cv::Mat1i::zeros(4 * kTileSize_px, 5 * kTileSize_px), map,
      [](int, const cv::Point2d& p) { return cv::Vec3f(float(p.x), float(p.y), 0); });
  EXPECT_EQ(out.shades, map.cost_px());
  for (int y = 0; y < out.light_cd_m2.height(); ++y)
    for (int x = 0; x < out.light_cd_m2.width(); ++x) {
      const cv::Point2d p = shading_point(map.at_pixel(x, y), x, y);
      EXPECT_EQ(out.light_cd_m2.pixels(y, x), cv::Vec3f(float(p.x), float(p.y), 0));
    }
}

TEST(CoarseShading, EveryPixelKeepsTheSurfaceItSees) {
  cv::Mat1i surface(kTileSize_px, kTileSize_px);
  for (int y = 0; y < surface.rows; ++y)
    for (int x = 0; x < surface.cols; ++x) surface(y, x) = x + y > 14;
  const ShadingRateMap coarsest = shading_rate_map({1}, 1, 1);
  const CoarseShading out = shade_coarsely(
      surface, coarsest, [](int s, const cv::Point2d&) { return cv::Vec3f(float(s), 0, 0); });
  for (int y = 0; y < surface.rows; ++y)
    for (int x = 0; x < surface.cols; ++x)
      EXPECT_EQ(out.light_cd_m2.pixels(y, x)[0], float(surface(y, x)));
  // 16 blocks, and a second shade in the four of the diagonal that the edge crosses.
  EXPECT_EQ(out.shades, 16 + 4);
}

TEST(CoarseShading, FullRateChangesNothing) {
  const RgbImage picture = random_picture(37, 21, 2);  // not whole tiles
  const ShadingRateMap map = shading_rate_map(std::vector<std::uint8_t>(6, 7), 3, 2);
  EXPECT_EQ(cv::norm(shade_picture_coarsely(picture, map).pixels, picture.pixels, cv::NORM_INF), 0);
}

TEST(CoarseShading, ImpossibleInputIsRefused) {
  EXPECT_THROW(shade_picture_coarsely(RgbImage(), random_map(1, 1, 1)), ArgumentError);
  EXPECT_THROW(shade_picture_coarsely(RgbImage(4, 4), ShadingRateMap{}), ArgumentError);
  EXPECT_THROW(shade_picture_coarsely(RgbImage(4, 4), ShadingRateMap{cv::Mat1b(1, 1, uchar{9})}),
               ArgumentError);
}

}  // namespace
}  // namespace wheatstone::testing
