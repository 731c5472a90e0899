#pragma once
// The GPU twin of render_drlf_cpu() (drlf.h): same arguments, same result within float precision.

#include <span>
#include <vector>

#include "core/rig_types.h"
#include "rendering/gl/objects.h"
#include "rendering/gl/offscreen.h"
#include "rendering/light_field/camera_mesh.h"
#include "rendering/light_field/drlf.h"

namespace wheatstone {

/// Holds the views of one light field on the GPU: 32-bit float, or 16-bit above 1 GB.
/// The context must outlive it.
class DrlfRenderer {
 public:
  /// Errors: ArgumentError without views, or naming the view whose size differs from the first's;
  /// GraphicsError when the GPU cannot hold them.
  DrlfRenderer(OffscreenContext&, std::span<const LightFieldView>);
  ~DrlfRenderer();
  DrlfRenderer(const DrlfRenderer&) = delete;
  DrlfRenderer& operator=(const DrlfRenderer&) = delete;

  /// Errors: those of make_drlf_geometry(); GraphicsError.
  DrlfResult render(const VirtualCamera&, const DrlfOptions&);

 private:
  void upload_views(std::span<const LightFieldView>);
  void upload_cells();
  void require_target(int width, int height);

  OffscreenContext& context_;
  std::vector<LightFieldView> views_;  // shares the caller's pixels
  CameraMesh mesh_;
  double light_scale_ = 1;
  int target_width_ = 0, target_height_ = 0;
  GlProgram program_;
  GlVertexArray vertices_;
  GlTexture images_, target_;
  GlFramebuffer framebuffer_;
  GlBuffer cameras_, cells_;
};

}  // namespace wheatstone
