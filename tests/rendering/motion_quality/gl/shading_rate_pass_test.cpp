#include "rendering/motion_quality/gl/shading_rate_pass.h"

#include <gmock/gmock.h>

#include "rendering/motion_quality/gl/coarse_shading.h"
#include "tests/rendering/gl_fixture.h"
#include "tests/rendering/motion_quality/gl/random_maps.h"

namespace wheatstone::testing {
namespace {

constexpr int kWidth = 83, kHeight = 51;  // the last tiles are partial

class ShadingRatePassTest : public GlFixture {};

TEST_F(ShadingRatePassTest, PicturesAgreeWithTheCpuTwin) {
  ShadingRatePass pass(*context_, ShadingRatePass::Path::kEmulation);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const RgbImage picture = random_picture(kWidth, kHeight, seed);
    // One map covers the picture, the other leaves its right and bottom to the nearest tiles.
    for (const ShadingRateMap& map : {random_map(6, 4, seed), random_map(4, 2, seed)}) {
      const RgbImage gpu = pass.shade_picture(picture, map);
      const RgbImage cpu = shade_picture_coarsely(picture, map);
      EXPECT_LT(cv::norm(gpu.pixels, cpu.pixels, cv::NORM_INF), 0.01);  // of 1000 cd/m^2
    }
  }
}

/// A triangle in front of a background. Both have colours that depend on where they are shaded,
/// the triangle's by an interpolated input.
constexpr const char* kTriangleVert = R"(#version 450 core
layout(location = 0) uniform vec2 size_px;
layout(location = 0) out vec4 position_px;
const vec2 kCorners_px[3] = vec2[3](vec2(7.3, 5.2), vec2(70.6, 11.9), vec2(30.4, 46.7));
void main() {
  vec2 p = kCorners_px[gl_VertexID];
  position_px = vec4(p, 0.0, 0.0);
  gl_Position = vec4((p + 0.5) / size_px * 2.0 - 1.0, 0.0, 1.0);
})";
constexpr const char* kTriangleFrag = R"(#version 450 core
vec4 at_shading_point(vec4 x);
layout(location = 0) in vec4 position_px;
layout(location = 0) out vec4 light;
void main() { light = vec4(at_shading_point(position_px).xy, 2.0, 1.0); })";
constexpr const char* kBackgroundVert = R"(#version 450 core
void main() {
  gl_Position = vec4(2.0 * vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) - 1.0, 0.0, 1.0);
})";
constexpr const char* kBackgroundFrag = R"(#version 450 core
vec2 shading_point();
layout(location = 0) out vec4 light;
void main() { light = vec4(shading_point(), 1.0, 1.0); })";

RgbImage draw_scene(ShadingRatePass& pass, const ShadingRateMap& map) {
  const GlProgram background = pass.make_program("background", kBackgroundVert, kBackgroundFrag);
  const GlProgram triangle = pass.make_program("triangle", kTriangleVert, kTriangleFrag);
  const GlVertexArray vertices = make_vertex_array();
  const GlTexture target = make_texture(GL_TEXTURE_2D);
  glTextureStorage2D(target.name(), 1, GL_RGBA32F, kWidth, kHeight);
  const GlFramebuffer framebuffer = make_framebuffer();
  glNamedFramebufferTexture(framebuffer.name(), GL_COLOR_ATTACHMENT0, target.name(), 0);
  pass.set_map(map, kWidth, kHeight);
  pass.draw([&] {
    draw_fullscreen(background, vertices, framebuffer, kWidth, kHeight);
    glUseProgram(triangle.name());
    glUniform2f(0, kWidth, kHeight);
    glDrawArrays(GL_TRIANGLES, 0, 3);
  });
  RgbImage out(kWidth, kHeight);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glGetTextureImage(target.name(), 0, GL_RGB, GL_FLOAT, kWidth * kHeight * 12, out.pixels.data);
  return out;
}

/// 1 where a pixel's centre lies in the triangle of kTriangleVert.
cv::Mat1i triangle_coverage() {
  const cv::Point2d corners[] = {{7.3, 5.2}, {70.6, 11.9}, {30.4, 46.7}};
  cv::Mat1i out(kHeight, kWidth, 1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int i = 0; i < 3; ++i) {
        const cv::Point2d edge = corners[(i + 1) % 3] - corners[i];
        if (edge.cross(cv::Point2d(x, y) - corners[i]) < 0) out(y, x) = 0;
      }
  return out;
}

TEST_F(ShadingRatePassTest, SurfacesAreShadedPerBlockAndSeenPerPixel) {
  ShadingRatePass pass(*context_, ShadingRatePass::Path::kEmulation);
  const cv::Mat1i surface = triangle_coverage();
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const ShadingRateMap map = random_map(6, 4, seed);
    const RgbImage gpu = draw_scene(pass, map);
    const CoarseShading cpu = shade_coarsely(surface, map, [](int s, const cv::Point2d& p) {
      return cv::Vec3f(float(p.x), float(p.y), float(1 + s));
    });
    EXPECT_LT(cv::norm(gpu.pixels, cpu.light_cd_m2.pixels, cv::NORM_INF), 1e-3);
  }
}

TEST_F(ShadingRatePassTest, HardwareDrawsTheSamePicture) {
  if (!ShadingRatePass::has_hardware(*context_))
    GTEST_SKIP() << context_->renderer() << " has no shading-rate image";
  ShadingRatePass hardware(*context_), emulation(*context_, ShadingRatePass::Path::kEmulation);
  ASSERT_EQ(hardware.path(), ShadingRatePass::Path::kHardware);
  const ShadingRateMap map = random_map(6, 4, 9);
  EXPECT_LT(
      cv::norm(draw_scene(hardware, map).pixels, draw_scene(emulation, map).pixels, cv::NORM_INF),
      1e-3);
}

TEST_F(ShadingRatePassTest, WithoutHardwareOneIsToldSo) {
  if (ShadingRatePass::has_hardware(*context_)) GTEST_SKIP() << "there is some";
  EXPECT_EQ(ShadingRatePass(*context_).path(), ShadingRatePass::Path::kEmulation);
  try {
    ShadingRatePass pass(*context_, ShadingRatePass::Path::kHardware);
    FAIL() << "accepted";
  } catch (const GraphicsError& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr("NV_shading_rate_image"));
  }
}

TEST_F(ShadingRatePassTest, ImpossibleInputIsRefused) {
  ShadingRatePass pass(*context_);
  EXPECT_THROW(pass.draw([] {}), ArgumentError);
  EXPECT_THROW(pass.set_map(ShadingRateMap{}, 16, 16), ArgumentError);
  EXPECT_THROW(pass.set_map(random_map(1, 1, 1), 0, 16), ArgumentError);
  EXPECT_THROW(pass.shade_picture(RgbImage(), random_map(1, 1, 1)), ArgumentError);
}

}  // namespace
}  // namespace wheatstone::testing
