#pragma once

namespace wheatstone {

/// The 16x16 LEDs in the ceiling of the box.
class LedArray {
 public:
  virtual ~LedArray() = default;
  /// Light output of every LED, linear, 0 = off, 1 = full. Throws DeviceError kOutOfRange.
  virtual void set_all(double drive) = 0;
};

}  // namespace wheatstone
