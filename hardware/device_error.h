#pragma once
// What can go wrong with a device, said so that capture can decide between retry and give up.

#include <string>

#include "core/error.h"

namespace wheatstone {

/// A device that did not do what it was asked. The device's state is unchanged unless said.
class DeviceError : public Error {
 public:
  enum class Kind { kTimeout, kDisconnected, kRefused, kFault, kNotHomed, kOutOfRange };

  DeviceError(Kind kind, const std::string& problem, const std::string& remedy)
      : Error(problem, remedy), kind_(kind) {}
  Kind kind() const { return kind_; }

 private:
  Kind kind_;
};

std::string to_string(DeviceError::Kind);  // "timeout", "disconnected", ...

}  // namespace wheatstone
