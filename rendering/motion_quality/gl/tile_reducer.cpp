#include "rendering/motion_quality/gl/tile_reducer.h"

#include <array>

#include "core/error.h"
#include "rendering/motion_quality/gl/tile_reduction_frag.h"

namespace wheatstone {
namespace {

GlTexture upload(const cv::Mat& image, GLenum internal_format, GLenum format, GLenum type) {
  const cv::Mat pixels = image.isContinuous() ? image : image.clone();
  GlTexture texture = make_texture(GL_TEXTURE_2D);
  glTextureStorage2D(texture.name(), 1, internal_format, pixels.cols, pixels.rows);
  glTextureParameteri(texture.name(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(texture.name(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTextureSubImage2D(texture.name(), 0, 0, 0, pixels.cols, pixels.rows, format, type, pixels.data);
  return texture;
}

}  // namespace

TileReducer::TileReducer(OffscreenContext& context) : context_(context) {
  context_.make_current();
  program_ = make_fullscreen_program("tile reduction", kTileReductionFrag);
  vertices_ = make_vertex_array();
  framebuffer_ = make_framebuffer();
}

TileReducer::~TileReducer() {
  try {
    context_.make_current();
  } catch (const GraphicsError&) {
    // Held by another thread: the objects die with the context.
  }
}

void TileReducer::require_target(const cv::Size& tiles) {
  if (tiles == target_) return;
  target_ = {};
  speed_luminance_ = make_texture(GL_TEXTURE_2D);
  material_ = make_texture(GL_TEXTURE_2D);
  glTextureStorage2D(speed_luminance_.name(), 1, GL_RGBA32F, tiles.width, tiles.height);
  glTextureStorage2D(material_.name(), 1, GL_RGBA32I, tiles.width, tiles.height);
  glNamedFramebufferTexture(framebuffer_.name(), GL_COLOR_ATTACHMENT0, speed_luminance_.name(), 0);
  glNamedFramebufferTexture(framebuffer_.name(), GL_COLOR_ATTACHMENT1, material_.name(), 0);
  const std::array<GLenum, 2> attachments = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  glNamedFramebufferDrawBuffers(framebuffer_.name(), 2, attachments.data());
  if (glCheckNamedFramebufferStatus(framebuffer_.name(), GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw GraphicsError("this driver cannot draw into 32-bit float and integer pictures at once",
                        "use another driver or reduce_to_tiles()");
  require_no_gl_error("making the tile buffers");
  target_ = tiles;
}

TileBuffers TileReducer::reduce(const PixelTextures& textures, const FrameGeometry& geometry) {
  require_valid(geometry);
  if (textures.width_px < 1 || textures.height_px < 1)
    throw ArgumentError("textures without pixels", "give a frame's");
  context_.make_current();
  const cv::Size tiles = tile_count(textures.width_px, textures.height_px);
  require_target(tiles);
  glBindTextureUnit(0, textures.motion_px);
  glBindTextureUnit(1, textures.material_mip);
  glBindTextureUnit(2, textures.light_cd_m2);
  glUseProgram(program_.name());
  glUniform1f(0, static_cast<float>(geometry.refresh_hz / geometry.ppd));  // as in the shader
  draw_fullscreen(program_, vertices_, framebuffer_, tiles.width, tiles.height);

  cv::Mat4f speed_luminance(tiles);
  cv::Mat4i material(tiles);
  const auto bytes = static_cast<GLsizei>(tiles.area() * 16);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glGetTextureImage(speed_luminance_.name(), 0, GL_RGBA, GL_FLOAT, bytes, speed_luminance.data);
  glGetTextureImage(material_.name(), 0, GL_RGBA_INTEGER, GL_INT, bytes, material.data);
  require_no_gl_error("reducing a frame to tiles");
  TileBuffers out{cv::Mat1d(tiles), cv::Mat1d(tiles), cv::Mat1i(tiles), cv::Mat1i(tiles),
                  cv::Mat1d(tiles)};
  for (int y = 0; y < tiles.height; ++y)
    for (int x = 0; x < tiles.width; ++x) {
      out.speed_x_deg_per_s(y, x) = speed_luminance(y, x)[0];
      out.speed_y_deg_per_s(y, x) = speed_luminance(y, x)[1];
      out.luminance_cd_m2(y, x) = speed_luminance(y, x)[2];
      out.material(y, x) = material(y, x)[0];
      out.mip_level(y, x) = material(y, x)[1];
    }
  return out;
}

TileBuffers TileReducer::reduce(const PixelBuffers& b, const FrameGeometry& geometry) {
  require_valid(b);
  context_.make_current();
  const GlTexture motion = upload(b.motion_px, GL_RG32F, GL_RG, GL_FLOAT);
  const GlTexture material_mip = upload(b.material_mip, GL_RG32I, GL_RG_INTEGER, GL_INT);
  const GlTexture light = upload(b.light_cd_m2.pixels, GL_RGBA32F, GL_RGB, GL_FLOAT);
  require_no_gl_error("uploading the buffers of a frame");
  return reduce(PixelTextures{motion.name(), material_mip.name(), light.name(), b.motion_px.cols,
                              b.motion_px.rows},
                geometry);
}

}  // namespace wheatstone
