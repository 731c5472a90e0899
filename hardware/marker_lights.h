#pragma once

#include <cstdint>

#include "hardware/device.h"

namespace wheatstone {

/// The small LEDs on the back wall that give the camera its pose. Where they are is the rig's
/// knowledge, not the device's.
class MarkerLights : public Device {
 public:
  using Mask = std::uint32_t;  // bit i: LED i is lit

  virtual int count() const = 0;
  /// Lights exactly these LEDs; returns when the device has confirmed it and the light is steady.
  /// Throws kOutOfRange for a bit beyond count(); kFault if the device confirms something else,
  /// three times.
  virtual void set(Mask, Deadline) = 0;
  /// Read back from the device.
  virtual Mask state(Deadline) = 0;
  virtual void all_off() noexcept = 0;

  Mask all() const { return count() >= 32 ? ~Mask{0} : (Mask{1} << count()) - 1; }
};

}  // namespace wheatstone
