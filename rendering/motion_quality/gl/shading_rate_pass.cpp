#include "rendering/motion_quality/gl/shading_rate_pass.h"

#include <fmt/format.h>

#include <array>

#include "core/error.h"
#include "rendering/motion_quality/alsarr/tile_buffers.h"
#include "rendering/motion_quality/gl/coarse_picture_frag.h"
#include "rendering/motion_quality/gl/shading_point_frag.h"

namespace wheatstone {
namespace {

constexpr GLuint kRatesUnit = 15;  // as in shading_point.frag

/// By rate index; entry 0 is not used by maps.
constexpr std::array<GLenum, kShadingRateCount + 1> kPalette = {
    GL_SHADING_RATE_1_INVOCATION_PER_PIXEL_NV,      GL_SHADING_RATE_1_INVOCATION_PER_4X4_PIXELS_NV,
    GL_SHADING_RATE_1_INVOCATION_PER_2X4_PIXELS_NV, GL_SHADING_RATE_1_INVOCATION_PER_4X2_PIXELS_NV,
    GL_SHADING_RATE_1_INVOCATION_PER_2X2_PIXELS_NV, GL_SHADING_RATE_1_INVOCATION_PER_1X2_PIXELS_NV,
    GL_SHADING_RATE_1_INVOCATION_PER_2X1_PIXELS_NV, GL_SHADING_RATE_1_INVOCATION_PER_PIXEL_NV};

/// On for as long as it lives.
class HardwareRates {
 public:
  explicit HardwareRates(GLuint texture) {
    glBindShadingRateImageNV(texture);
    glShadingRateImagePaletteNV(0, 0, static_cast<GLsizei>(kPalette.size()), kPalette.data());
    glEnable(GL_SHADING_RATE_IMAGE_NV);
  }
  ~HardwareRates() {
    glDisable(GL_SHADING_RATE_IMAGE_NV);
    glBindShadingRateImageNV(0);
  }
  HardwareRates(const HardwareRates&) = delete;
  HardwareRates& operator=(const HardwareRates&) = delete;
};

}  // namespace

bool ShadingRatePass::has_hardware(OffscreenContext& context) {
  context.make_current();
  if (!epoxy_has_gl_extension("GL_NV_shading_rate_image")) return false;
  GLint width = 0, height = 0, palette = 0;
  glGetIntegerv(GL_SHADING_RATE_IMAGE_TEXEL_WIDTH_NV, &width);
  glGetIntegerv(GL_SHADING_RATE_IMAGE_TEXEL_HEIGHT_NV, &height);
  glGetIntegerv(GL_SHADING_RATE_IMAGE_PALETTE_SIZE_NV, &palette);
  return width == kTileSize_px && height == kTileSize_px &&
         palette >= static_cast<GLint>(kPalette.size());
}

ShadingRatePass::ShadingRatePass(OffscreenContext& context)
    : ShadingRatePass(context, has_hardware(context) ? Path::kHardware : Path::kEmulation) {}

ShadingRatePass::ShadingRatePass(OffscreenContext& context, Path path)
    : context_(context), path_(path) {
  if (path == Path::kHardware && !has_hardware(context))
    throw GraphicsError(
        fmt::format("{} has no shading-rate image with tiles of 16x16 px", context.renderer()),
        "use the emulation, or a driver with NV_shading_rate_image");
  context_.make_current();
}

ShadingRatePass::~ShadingRatePass() {
  try {
    context_.make_current();
  } catch (const GraphicsError&) {
    // Held by another thread: the objects die with the context.
  }
}

GlProgram ShadingRatePass::make_program(const std::string& name, const std::string& vertex_source,
                                        const std::string& fragment_source) const {
  context_.make_current();
  return wheatstone::make_program(name, vertex_source,
                                  std::vector<std::string>{fragment_source, kShadingPointFrag});
}

void ShadingRatePass::set_map(const ShadingRateMap& map, int width_px, int height_px) {
  require_valid_rates(map);
  if (width_px < 1 || height_px < 1)
    throw ArgumentError(fmt::format("a framebuffer of {}x{} px", width_px, height_px),
                        "give its size");
  const cv::Size tiles = tile_count(width_px, height_px);
  cv::Mat1b covering(tiles);  // hardware shades at full rate beyond its image
  for (int y = 0; y < tiles.height; ++y)
    for (int x = 0; x < tiles.width; ++x)
      covering(y, x) =
          map.rate_index(std::min(y, map.tiles_y() - 1), std::min(x, map.tiles_x() - 1));
  context_.make_current();
  rates_ = make_texture(GL_TEXTURE_2D);
  glTextureStorage2D(rates_.name(), 1, GL_R8UI, tiles.width, tiles.height);
  glTextureParameteri(rates_.name(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(rates_.name(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(rates_.name(), 0, 0, 0, tiles.width, tiles.height, GL_RED_INTEGER,
                      GL_UNSIGNED_BYTE, covering.data);
  require_no_gl_error("uploading a shading-rate map");
  has_map_ = true;
}

void ShadingRatePass::draw(const std::function<void()>& draw) {
  if (!has_map_) throw ArgumentError("there is no shading-rate map to draw with", "set one first");
  context_.make_current();
  glBindTextureUnit(kRatesUnit, rates_.name());
  if (path_ == Path::kHardware) {
    const HardwareRates rates(rates_.name());
    draw();
  } else {
    draw();
  }
  require_no_gl_error("drawing with a shading-rate map");
}

RgbImage ShadingRatePass::shade_picture(const RgbImage& picture, const ShadingRateMap& map) {
  if (picture.empty()) throw ArgumentError("a picture without pixels", "give one");
  const int width = picture.width(), height = picture.height();
  set_map(map, width, height);
  const GlProgram program = make_fullscreen_program(
      "coarse picture", std::vector<std::string>{kCoarsePictureFrag, kShadingPointFrag});
  const GlVertexArray vertices = make_vertex_array();
  const GlTexture source = make_texture(GL_TEXTURE_2D), target = make_texture(GL_TEXTURE_2D);
  const cv::Mat pixels =
      picture.pixels.isContinuous() ? cv::Mat(picture.pixels) : picture.pixels.clone();
  glTextureStorage2D(source.name(), 1, GL_RGBA32F, width, height);
  glTextureParameteri(source.name(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTextureParameteri(source.name(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(source.name(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(source.name(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTextureSubImage2D(source.name(), 0, 0, 0, width, height, GL_RGB, GL_FLOAT, pixels.data);
  glTextureStorage2D(target.name(), 1, GL_RGBA32F, width, height);
  const GlFramebuffer framebuffer = make_framebuffer();
  glNamedFramebufferTexture(framebuffer.name(), GL_COLOR_ATTACHMENT0, target.name(), 0);
  require_no_gl_error("uploading a picture");
  draw([&] {
    glBindTextureUnit(0, source.name());
    draw_fullscreen(program, vertices, framebuffer, width, height);
  });
  RgbImage out(width, height);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glGetTextureImage(target.name(), 0, GL_RGB, GL_FLOAT,
                    static_cast<GLsizei>(out.pixels.total() * out.pixels.elemSize()),
                    out.pixels.data);
  require_no_gl_error("reading a picture");
  return out;
}

}  // namespace wheatstone
