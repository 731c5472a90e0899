#pragma once
// What all devices have in common.
//
// A device is open from construction to destruction; its destructor leaves it safe (standing, dark)
// as far as it still answers. Calls come from one thread at a time, but for those that are noexcept
// and stop something (stop(), all_off(), abort()): they may come from any thread at any time and
// never wait for a slow call. Every other call that talks to the device takes a Deadline and
// neither outlives it nor sleeps through a request to stop: it throws DeviceError kTimeout, or
// Cancelled. After kDisconnected every call throws kDisconnected; only a new object opens the
// device again.

#include <string>

#include "core/clock.h"
#include "hardware/device_error.h"

namespace wheatstone {

/// As the device itself says; empty where it does not.
struct DeviceIdentity {
  std::string driver;  // "simulated", "grbl", ...
  std::string model, serial, firmware;
  std::string address;  // how it was reached: "/dev/ttyACM0", "usb 1:5", ...
};

class Device {
 public:
  virtual ~Device() = default;
  virtual DeviceIdentity identity() const = 0;
};

}  // namespace wheatstone
