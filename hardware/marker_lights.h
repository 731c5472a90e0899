#pragma once

#include <Eigen/Core>
#include <vector>

namespace wheatstone {

/// The small LEDs on the back wall that give the camera its pose.
class MarkerLights {
 public:
  virtual ~MarkerLights() = default;
  virtual int count() const = 0;
  /// Throws DeviceError kOutOfRange unless 0 <= index < count().
  virtual void set(int index, bool on) = 0;
  virtual std::vector<Eigen::Vector3d> positions_rsb_mm() const = 0;
};

}  // namespace wheatstone
