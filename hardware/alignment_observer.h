#pragma once

#include <Eigen/Core>

#include "core/clock.h"
#include "core/rig_types.h"

namespace wheatstone {

/// Somebody (or a camera at the eye) who moves a cross on a display until it covers a point.
class AlignmentObserver {
 public:
  virtual ~AlignmentObserver() = default;
  /// LCD pixel of `id` seen on the point. Throws DeviceError (kTimeout, kOutOfRange when the
  /// point cannot be covered by that display).
  virtual Eigen::Vector2d align(DisplayId id, const Eigen::Vector3d& p_rsb_mm, Deadline) = 0;
};

}  // namespace wheatstone
