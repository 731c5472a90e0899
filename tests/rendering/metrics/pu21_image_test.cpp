// The vectorised encoding and the GLSL function against the formula in double.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <bit>
#include <cmath>
#include <limits>
#include <memory>

#include "core/error.h"
#include "core/random.h"
#include "rendering/gl/objects.h"
#include "rendering/gl/offscreen.h"
#include "rendering/metrics/pu21.h"
#include "rendering/metrics/pu21_table.h"
#include "rendering/metrics/row_kernels.h"
#include "vectors.h"

namespace wheatstone {
namespace {

constexpr Pu21Variant kVariants[] = {Pu21Variant::kBanding, Pu21Variant::kBandingGlare,
                                     Pu21Variant::kPeaks, Pu21Variant::kPeaksGlare};

/// Every 101st float from half the lower clamp to twice the upper, the neighbours of every power of
/// two, both clamps and zero.
std::vector<float> luminances() {
  std::vector<float> out = {0,
                            0.005F,
                            std::nextafter(0.005F, 0.0F),
                            std::nextafter(0.005F, 1.0F),
                            10000,
                            std::nextafter(10000.0F, 0.0F),
                            1e30F};
  for (auto bits = std::bit_cast<std::uint32_t>(0.0025F); bits < std::bit_cast<std::uint32_t>(2e4F);
       bits += 101)
    out.push_back(std::bit_cast<float>(bits));
  for (int e = -9; e < 15; ++e)
    for (int ulp = -2; ulp <= 2; ++ulp)
      out.push_back(std::bit_cast<float>(std::bit_cast<std::uint32_t>(std::ldexp(1.0F, e)) +
                                         static_cast<std::uint32_t>(ulp)));
  return out;
}

TEST(Pu21Image, WithinTheStatedToleranceOfTheFormula) {
  const std::vector<float> light = luminances();
  std::vector<float> encoded(light.size());
  for (const Pu21Variant variant : kVariants) {
    pu21_encode(light, encoded, variant);
    double worst = 0;
    for (std::size_t i = 0; i < light.size(); ++i) {
      const double exact = pu21_encode(light[i], variant);
      worst = std::max(worst, std::abs(encoded[i] - exact) / (1e-6 + 1e-6 * exact));
    }
    EXPECT_LT(worst, 1) << to_string(variant);
    // Where the curve has left its foot, the relative error alone keeps to 1e-6.
    for (std::size_t i = 0; i < light.size(); ++i)
      if (const double exact = pu21_encode(light[i], variant); exact > 1) {
        ASSERT_NEAR(encoded[i], exact, 1e-6 * exact) << to_string(variant) << " " << light[i];
      }
  }
}

TEST(Pu21Image, EveryVectorLevelGivesTheSameBits) {
  std::vector<float> light = luminances();
  light.resize(1000003);  // a rest after every vector width
  for (const Pu21Variant variant : kVariants) {
    const detail::Pu21Table& table = detail::pu21_table(variant);
    std::vector<float> portable(light.size()), vector(light.size());
    EXPECT_TRUE(detail::pu21_encode_span(table, light.data(), light.size(), portable.data(),
                                         Simd::kPortable));
    for (const Simd simd : available_simd()) {
      EXPECT_TRUE(detail::pu21_encode_span(table, light.data(), light.size(), vector.data(), simd));
      EXPECT_EQ(vector, portable) << to_string(variant) << " " << static_cast<int>(simd);
    }
  }
}

TEST(Pu21Image, LuminanceRowsAreTheSameBitsAtEveryLevel) {
  RandomStream random(1, 0);
  std::vector<float> rgb(3 * 1001);
  for (float& v : rgb) v = static_cast<float>(std::exp(10 * random.uniform() - 4));
  std::vector<float> portable(1001), vector(1001);
  EXPECT_TRUE(detail::luminance_row(rgb.data(), 1001, portable.data(), Simd::kPortable));
  for (std::size_t i = 0; i < portable.size(); ++i)
    EXPECT_NEAR(portable[i],
                kLuminanceWeights[0] * rgb[3 * i] + kLuminanceWeights[1] * rgb[3 * i + 1] +
                    kLuminanceWeights[2] * rgb[3 * i + 2],
                3e-7 * portable[i]);
  for (const Simd simd : available_simd()) {
    EXPECT_TRUE(detail::luminance_row(rgb.data(), 1001, vector.data(), simd));
    EXPECT_EQ(vector, portable);
  }
}

TEST(Pu21Image, ImpossibleLightIsCountedAndLocated) {
  for (const float bad : {-1.0F, -1e-30F, std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity()})
    for (const std::size_t place : {0, 7, 16, 40}) {  // in vectors and in the rest after them
      std::vector<float> light(41, 1.0F), encoded(41);
      light[place] = light[40] = bad;
      try {
        pu21_encode(light, encoded);
        ADD_FAILURE() << "accepted " << bad;
      } catch (const ArgumentError& e) {
        EXPECT_THAT(e.what(), ::testing::HasSubstr(place == 40 ? "1 of 41" : "2 of 41"));
        EXPECT_THAT(e.what(), ::testing::HasSubstr("index " + std::to_string(place)));
      }
      for (const Simd simd : available_simd())
        EXPECT_FALSE(detail::pu21_encode_span(detail::pu21_table(Pu21Variant::kBanding),
                                              light.data(), 41, encoded.data(), simd));
    }
  std::vector<float> three(3), two(2);
  EXPECT_THROW(pu21_encode(three, two), ArgumentError);
}

TEST(Pu21Image, VariantsHaveNames) {
  for (const Pu21Variant variant : kVariants)
    EXPECT_EQ(pu21_variant_from_string(to_string(variant)), variant);
  EXPECT_THROW(pu21_variant_from_string("bandig"), ArgumentError);
}

/// PSNR straight from its definition, in double.
double plain_psnr_rgb(const RgbImage& a, const RgbImage& b) {
  double sum = 0;
  for (int r = 0; r < a.height(); ++r)
    for (int c = 0; c < a.width(); ++c)
      for (int k = 0; k < 3; ++k)
        sum += std::pow(pu21_encode(a.pixels(r, c)[k]) - pu21_encode(b.pixels(r, c)[k]), 2);
  return 10 * std::log10(256.0 * 256.0 * 3 * static_cast<double>(a.pixels.total()) / sum);
}

// From 20 to 130 dB, on both sides of the switch to double precision.
TEST(Pu21Image, PsnrKeepsItsToleranceAtEveryHeight) {
  const RgbImage reference = vector_image("img/a_ref.pfm");
  for (const double noise : {0.3, 0.03, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6}) {
    RandomStream random(3, 0);
    RgbImage test(reference.pixels.clone());
    for (cv::Vec3f& p : test.pixels)
      for (int k = 0; k < 3; ++k) p[k] *= static_cast<float>(1 + noise * (random.uniform() - 0.5));
    EXPECT_NEAR(pu21_psnr_rgb(test, reference), plain_psnr_rgb(test, reference), 1e-4) << noise;
  }
}

TEST(Pu21Image, PsnrDoesNotDependOnTheThreads) {
  const RgbImage a = vector_image("img/b_noise05.pfm"), b = vector_image("img/b_ref.pfm");
  const double with_all = pu21_psnr_rgb(a, b);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(pu21_psnr_rgb(a, b), with_all);
}

TEST(Pu21Glsl, AgreesWithTheFormula) {
  std::unique_ptr<OffscreenContext> context;
  try {
    context = std::make_unique<OffscreenContext>();
  } catch (const GraphicsError& e) {
    GTEST_SKIP() << e.what();
  }
  // One column for each luminance, one row for each variant: the encoded and the decoded value.
  constexpr int kCount = 1024;
  std::vector<float> light(kCount);
  for (int i = 0; i < kCount; ++i)
    light[i] = static_cast<float>(0.004 * std::pow(12000 / 0.004, i / (kCount - 1.0)));
  const GlProgram program = make_fullscreen_program(
      "pu21",
      std::string("#version 450 core\n") + pu21_glsl() +
          "layout(std430, binding = 0) readonly buffer Light { float light[]; };\n"
          "layout(location = 0) out vec4 result;\n"
          "void main() {\n"
          "  ivec2 at = ivec2(gl_FragCoord.xy);\n"
          "  float v = pu21_encode(light[at.x], at.y);\n"
          "  result = vec4(v, pu21_decode(v, at.y), pu21_encode(vec3(light[at.x]), at.y).g, "
          "1);\n"
          "}\n");
  const GlBuffer buffer = make_buffer();
  glNamedBufferStorage(buffer.name(), kCount * sizeof(float), light.data(), 0);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer.name());
  const GlVertexArray vertices = make_vertex_array();
  const GlTexture target = make_texture(GL_TEXTURE_2D);
  glTextureStorage2D(target.name(), 1, GL_RGBA32F, kCount, 4);
  const GlFramebuffer framebuffer = make_framebuffer();
  glNamedFramebufferTexture(framebuffer.name(), GL_COLOR_ATTACHMENT0, target.name(), 0);
  draw_fullscreen(program, vertices, framebuffer, kCount, 4);
  cv::Mat4f out(4, kCount);
  glGetTextureImage(target.name(), 0, GL_RGBA, GL_FLOAT,
                    static_cast<GLsizei>(out.total() * out.elemSize()), out.data);
  require_no_gl_error("reading PU21 values");
  for (int v = 0; v < 4; ++v)
    for (int i = 0; i < kCount; ++i) {
      const double encoded = pu21_encode(light[i], kVariants[v]);
      EXPECT_NEAR(out(v, i)[0], encoded, 0.002 + 1e-5 * encoded) << light[i];
      EXPECT_EQ(out(v, i)[0], out(v, i)[2]);
      const double decoded = pu21_decode(out(v, i)[0], kVariants[v]);
      EXPECT_NEAR(out(v, i)[1], decoded, 2e-4 + 2e-3 * decoded) << light[i];
    }
}

}  // namespace
}  // namespace wheatstone
