#pragma once
// The GPU twin of reduce_to_tiles() (tile_reduction.h).

#include "rendering/gl/objects.h"
#include "rendering/gl/offscreen.h"
#include "rendering/motion_quality/gl/tile_reduction.h"

namespace wheatstone {

/// A frame's buffers where the renderer has them, textures of one size, row 0 first. The
/// integer one must have nearest filtering, or OpenGL reads zeros.
struct PixelTextures {
  GLuint motion_px = 0;     // RG, float
  GLuint material_mip = 0;  // RG, integer
  GLuint light_cd_m2 = 0;   // RGB(A), float
  int width_px = 0, height_px = 0;
};

/// The context must outlive it.
class TileReducer {
 public:
  /// Errors: GraphicsError.
  explicit TileReducer(OffscreenContext&);
  ~TileReducer();
  TileReducer(const TileReducer&) = delete;
  TileReducer& operator=(const TileReducer&) = delete;

  /// Values are not judged on the GPU; the allocation refuses impossible ones.
  /// Errors: ArgumentError for an empty frame or an impossible geometry; GraphicsError.
  TileBuffers reduce(const PixelTextures&, const FrameGeometry&);
  /// Uploads first. Errors: as reduce_to_tiles(); GraphicsError.
  TileBuffers reduce(const PixelBuffers&, const FrameGeometry&);

 private:
  void require_target(const cv::Size& tiles);

  OffscreenContext& context_;
  GlProgram program_;
  GlVertexArray vertices_;
  GlFramebuffer framebuffer_;
  GlTexture speed_luminance_, material_;
  cv::Size target_;
};

}  // namespace wheatstone
