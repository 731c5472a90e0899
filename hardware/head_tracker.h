#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "core/rig_types.h"
#include "hardware/device.h"

namespace wheatstone {

struct EyeCentre {
  Eigen::Vector3d p_rsb_mm = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_mm2 = Eigen::Matrix3d::Zero();
  double confidence = 0;  // 0..1, as the tracker says
};

struct EyeCentres {
  std::array<std::optional<EyeCentre>, 2> eyes;  // at index 0 left, 1 right; none: lost or a blink
  Nanoseconds time_ns = 0;  // of the exposure, on the machine's monotonic clock
};

/// Where the observer's eyes are.
class HeadTracker : public Device {
 public:
  /// The newest sample that was not yet handed out; older ones are skipped.
  virtual EyeCentres next(Deadline) = 0;
};

}  // namespace wheatstone
