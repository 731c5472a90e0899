#include "rendering/motion_quality/gl/tile_reduction.h"

#include <gmock/gmock.h>

#include <limits>

#include "rendering/motion_quality/gl/tile_reducer.h"
#include "tests/rendering/gl_fixture.h"
#include "tests/rendering/motion_quality/gl/random_maps.h"

namespace wheatstone::testing {
namespace {

PixelBuffers random_buffers(int width, int height, std::uint64_t seed) {
  RandomStream random(seed, 2);
  PixelBuffers b{cv::Mat2f(height, width), cv::Mat2i(height, width),
                 random_picture(width, height, seed)};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      b.motion_px(y, x) = {static_cast<float>(10 * random.normal()),
                           static_cast<float>(3 * random.normal())};
      b.material_mip(y, x) = {static_cast<int>(random.next() % 4),
                              static_cast<int>(random.next() % 12)};
    }
  return b;
}

TEST(TileReduction, MotionIsMeanMagnitudeInDegreesPerSecond) {
  PixelBuffers b = random_buffers(32, 16, 1);
  b.motion_px(cv::Rect(0, 0, 16, 16)).setTo(cv::Scalar(-2, 1));
  b.motion_px(cv::Rect(0, 0, 8, 16)).setTo(cv::Scalar(2, 3));
  const TileBuffers tiles = reduce_to_tiles(b, {32, 16, 60, 30});
  ASSERT_EQ(tiles.material.size(), cv::Size(2, 1));
  EXPECT_DOUBLE_EQ(tiles.speed_x_deg_per_s(0, 0), 2 * 60 / 30.0);
  EXPECT_DOUBLE_EQ(tiles.speed_y_deg_per_s(0, 0), 2 * 60 / 30.0);
}

TEST(TileReduction, TheMostFrequentMaterialWithItsFinestMip) {
  PixelBuffers b = random_buffers(16, 16, 1);
  b.material_mip.setTo(cv::Scalar(8, 1));
  b.material_mip(cv::Rect(0, 0, 16, 10)).setTo(cv::Scalar(5, 6));  // 8 of 16 samples, the first
  b.material_mip(9, 6) = {5, 0};                                   // not sampled
  b.material_mip(6, 10) = {5, 3};
  const TileBuffers tiles = reduce_to_tiles(b, {});
  EXPECT_EQ(tiles.material(0, 0), 5);
  EXPECT_EQ(tiles.mip_level(0, 0), 3);
}

TEST(TileReduction, ImpossibleBuffersAreRefused) {
  const auto error_of = [](auto change) -> std::string {
    PixelBuffers b = random_buffers(20, 20, 1);
    change(b);
    try {
      reduce_to_tiles(b, {});
    } catch (const ArgumentError& e) {
      return e.what();
    }
    return "no error";
  };
  using ::testing::HasSubstr;
  EXPECT_EQ(error_of([](PixelBuffers&) {}), "no error");
  EXPECT_THAT(error_of([](PixelBuffers& b) { b = {}; }), HasSubstr("without pixels"));
  EXPECT_THAT(error_of([](PixelBuffers& b) { b.material_mip = cv::Mat2i(20, 21); }),
              HasSubstr("materials 21x20"));
  EXPECT_THAT(error_of([](PixelBuffers& b) { b.light_cd_m2 = RgbImage(1, 1); }),
              HasSubstr("light 1x1"));
  EXPECT_THAT(error_of([](PixelBuffers& b) {
                b.motion_px(3, 7)[1] = std::numeric_limits<float>::infinity();
              }),
              HasSubstr("motion of pixel (7, 3)"));
  EXPECT_THAT(error_of([](PixelBuffers& b) { b.material_mip(3, 7)[0] = -1; }),
              HasSubstr("pixel (7, 3)"));
  EXPECT_THAT(error_of([](PixelBuffers& b) { b.light_cd_m2.pixels(3, 7)[0] = -1; }),
              HasSubstr("frame before"));
}

class TileReducerTest : public GlFixture {};

TEST_F(TileReducerTest, AgreesWithTheCpuTwin) {
  TileReducer reducer(*context_);
  for (const cv::Size& size : {cv::Size(83, 51), cv::Size(64, 32), cv::Size(5, 3)}) {
    const PixelBuffers b = random_buffers(size.width, size.height, 4);
    const FrameGeometry geometry{size.width, size.height, 85, 45};
    const TileBuffers cpu = reduce_to_tiles(b, geometry), gpu = reducer.reduce(b, geometry);
    const auto expect_near = [](const cv::Mat1d& a, const cv::Mat1d& e) {
      ASSERT_EQ(a.size(), e.size());
      EXPECT_LT(cv::norm(a, e, cv::NORM_INF), 1e-5 * cv::norm(e, cv::NORM_INF));
    };
    expect_near(gpu.speed_x_deg_per_s, cpu.speed_x_deg_per_s);
    expect_near(gpu.speed_y_deg_per_s, cpu.speed_y_deg_per_s);
    expect_near(gpu.luminance_cd_m2, cpu.luminance_cd_m2);
    EXPECT_EQ(cv::norm(gpu.material, cpu.material, cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(gpu.mip_level, cpu.mip_level, cv::NORM_INF), 0);
  }
}

TEST_F(TileReducerTest, ImpossibleInputIsRefused) {
  TileReducer reducer(*context_);
  EXPECT_THROW(reducer.reduce(PixelTextures{}, FrameGeometry{}), ArgumentError);
  EXPECT_THROW(reducer.reduce(PixelBuffers{}, FrameGeometry{}), ArgumentError);
  EXPECT_THROW(reducer.reduce(random_buffers(16, 16, 1), {16, 16, 0, 45}), ArgumentError);
}

}  // namespace
}  // namespace wheatstone::testing
