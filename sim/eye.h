#pragma once
// What a camera with a pinhole at the centre of an eye would photograph.

#include "core/geometry.h"
#include "core/image.h"
#include "sim/world.h"

namespace wheatstone {

/// Size of an eye's photograph. Its window is the lit area of the far display as that eye sees
/// it, so its pixel grid lies straight on the far plane.
struct EyeCamera {
  int width_px = 512, height_px = 384;
  int subsamples = 3;  // per axis, fixed
};

class EyePhotograph {
 public:
  explicit EyePhotograph(const World& world) : world_(world) {}

  /// The light of both displays of the eye added along each ray.
  RgbImage photograph_displays(Eye, const EyeCamera&) const;
  /// The real box under its present light.
  RgbImage photograph_box(Eye, const EyeCamera&) const;

  /// Geometry of these photographs.
  static Intrinsics intrinsics(Eye, const EyeCamera&);
  static RigidTransform T_eye_rsb(Eye);

 private:
  const World& world_;
};

}  // namespace wheatstone
