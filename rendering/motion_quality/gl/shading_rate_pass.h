#pragma once
// Drawing with a shading-rate map in OpenGL, with the hardware's shading-rate image where there is
// one (NV_shading_rate_image), otherwise with the same picture by emulation.

#include <functional>
#include <string>

#include "core/image.h"
#include "rendering/gl/objects.h"
#include "rendering/gl/offscreen.h"
#include "rendering/motion_quality/alsarr/shading_rate.h"

namespace wheatstone {

/// Programs for this pass come from make_program(), and their fragment shaders compute from
///     vec2 shading_point();               // OpenCV pixel, instead of gl_FragCoord.xy - 0.5
///     vec4 at_shading_point(vec4 input);  // for interpolated inputs
/// which they declare as above. In both ways a block has one value per surface, at its centre, and
/// visibility stays per pixel. Only the hardware way saves time: the emulation shades every pixel,
/// with the inputs of its block. Texture unit 15 belongs to the pass.
/// The context must outlive it.
class ShadingRatePass {
 public:
  enum class Path { kHardware, kEmulation };

  /// The extension is there and has the tiles of 16 x 16 px that maps are made for.
  static bool has_hardware(OffscreenContext&);

  /// The hardware where there is some. Errors: GraphicsError.
  explicit ShadingRatePass(OffscreenContext&);
  /// Errors: GraphicsError, also for kHardware where there is none.
  ShadingRatePass(OffscreenContext&, Path);
  ~ShadingRatePass();
  ShadingRatePass(const ShadingRatePass&) = delete;
  ShadingRatePass& operator=(const ShadingRatePass&) = delete;
  Path path() const { return path_; }

  /// Errors: GraphicsError with the driver's log.
  GlProgram make_program(const std::string& name, const std::string& vertex_source,
                         const std::string& fragment_source) const;

  /// For a framebuffer of this size; pixels beyond the map have the rate of the nearest tile.
  /// Errors: ArgumentError for an invalid map or size; GraphicsError.
  void set_map(const ShadingRateMap&, int width_px, int height_px);

  /// What draw() draws is shaded at the map's rates. Errors: ArgumentError without a map;
  /// GraphicsError; those of draw().
  void draw(const std::function<void()>& draw);

  /// The GPU twin of shade_picture_coarsely() (coarse_shading.h). Errors: as set_map().
  RgbImage shade_picture(const RgbImage&, const ShadingRateMap&);

 private:
  OffscreenContext& context_;
  Path path_;
  GlTexture rates_;
  bool has_map_ = false;
};

}  // namespace wheatstone
