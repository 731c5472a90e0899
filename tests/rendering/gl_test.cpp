#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "core/error.h"
#include "core/random.h"
#include "rendering/gl/objects.h"
#include "rendering/light_field/drlf_renderer.h"
#include "tests/rendering/gl_fixture.h"
#include "tests/rendering/synthetic_light_field.h"

namespace wheatstone::testing {
namespace {

TEST(OffscreenContext, WithoutADriverItSaysWhatToInstall) {
  // In a process of its own: EGL reads the variable once. The child leaves by _exit.
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent", 1);
    int status = 1;
    try {
      OffscreenContext context;
    } catch (const GraphicsError& e) {
      status = std::string(e.what()).find("libgl1-mesa-dri") != std::string::npos ? 0 : 2;
    } catch (...) {
      status = 3;
    }
    _exit(status);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

class Gl : public GlFixture {};

TEST_F(Gl, NamesTheDriver) {
  EXPECT_FALSE(context_->renderer().empty());
  EXPECT_FALSE(context_->version().empty());
}

TEST_F(Gl, AShaderErrorCarriesTheDriversLog) {
  try {
    make_fullscreen_program("broken", "#version 450 core\nvoid main() { nonsense = 1; }\n");
    FAIL() << "compiled";
  } catch (const GraphicsError& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr("nonsense"));
    EXPECT_THAT(e.what(), ::testing::HasSubstr("broken"));
  }
}

TEST_F(Gl, FragCoordMinusAHalfIsTheOpenCvPixel) {
  const GlProgram program =
      make_fullscreen_program("pixel",
                              "#version 450 core\nlayout(location = 0) out vec4 c;\n"
                              "void main() { c = vec4(gl_FragCoord.xy - 0.5, 0, 1); }\n");
  const GlVertexArray vertices = make_vertex_array();
  const GlTexture target = make_texture(GL_TEXTURE_2D);
  glTextureStorage2D(target.name(), 1, GL_RGBA32F, 5, 3);
  const GlFramebuffer framebuffer = make_framebuffer();
  glNamedFramebufferTexture(framebuffer.name(), GL_COLOR_ATTACHMENT0, target.name(), 0);
  draw_fullscreen(program, vertices, framebuffer, 5, 3);
  cv::Mat4f out(3, 5);
  glGetTextureImage(target.name(), 0, GL_RGBA, GL_FLOAT, 5 * 3 * 16, out.data);
  require_no_gl_error("reading");
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 5; ++i) EXPECT_EQ(out(j, i), cv::Vec4f(float(i), float(j), 0, 1));
}

TEST_F(Gl, ViewsWithoutAPictureAreNamed) {
  auto views = painted_grid(3, 1, 20);
  views[2].light_cd_m2 = RgbImage();
  try {
    DrlfRenderer renderer(*context_, views);
    FAIL() << "accepted";
  } catch (const ArgumentError& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr("'0,2'"));
  }
}

/// Each view cropped by another amount, with its own principal point.
void crop_unequally(std::vector<LightFieldView>& views) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    LightFieldView& view = views[i];
    const int n = static_cast<int>(i % 4);
    const cv::Rect kept(3 * n, 5 * (3 - n), 160 - 11 * n, 120 - 17 * (3 - n));
    view.light_cd_m2 = RgbImage(view.light_cd_m2.pixels(kept).clone());
    view.intrinsics.cx_px -= kept.x;
    view.intrinsics.cy_px -= kept.y;
    view.intrinsics.width_px = kept.width;
    view.intrinsics.height_px = kept.height;
  }
}

TEST_F(Gl, DrlfAgreesWithItsCpuTwin) {
  // Random pictures that differ between cameras: a wrong camera or row would show at once.
  RandomStream random(3, 0);
  int run = 0;
  for (auto views : {painted_grid(5, 1, 20), painted_grid(4, 3, 20), painted_grid(4, 3, 20)}) {
    for (auto& view : views) {
      cv::Mat3f coarse(6, 8);
      for (auto& p : coarse)
        for (int k = 0; k < 3; ++k) p[k] = static_cast<float>(1000 * random.uniform());
      cv::resize(coarse, view.light_cd_m2.pixels, {160, 120}, 0, 0, cv::INTER_LINEAR);
    }
    if (run++ == 2) crop_unequally(views);
    DrlfRenderer renderer(*context_, views);
    for (const auto aperture : {DrlfOptions::Aperture::kNearest, DrlfOptions::Aperture::kLinear,
                                DrlfOptions::Aperture::kGaussian})
      for (const double focal : {350.0, 60.0}) {  // the second one looks past the data images
        VirtualCamera camera = virtual_camera({6.3, 2.2, 552});
        camera.K(0, 0) = camera.K(1, 1) = focal;
        const DrlfOptions options = focused_on_the_plane(aperture);
        const DrlfResult cpu = render_drlf_cpu(views, camera, options);
        const DrlfResult gpu = renderer.render(camera, options);
        EXPECT_LT(cv::norm(cpu.coverage.pixels, gpu.coverage.pixels, cv::NORM_INF), 0.01);
        // Where coverage is a rounding error, so is the choice of what to show.
        const cv::Mat1b covered = cpu.coverage.pixels > 0.001f;
        cv::Mat difference;
        cv::absdiff(cpu.light_cd_m2.pixels, gpu.light_cd_m2.pixels, difference);
        difference.setTo(cv::Scalar::all(0), covered == 0);
        if (aperture == DrlfOptions::Aperture::kNearest) {
          // On a midline between cameras float and double may choose differently.
          int over = 0;
          for (const auto& d : cv::Mat3f(difference)) over += std::max({d[0], d[1], d[2]}) > 10;
          EXPECT_LE(over, camera.height);
        } else {
          EXPECT_LT(cv::norm(difference, cv::NORM_INF), 10);  // 1 % of the peak
        }
      }
  }
}

}  // namespace
}  // namespace wheatstone::testing
