#include "hardware/device_error.h"

namespace wheatstone {

std::string to_string(DeviceError::Kind kind) {
  switch (kind) {
    case DeviceError::Kind::kTimeout:
      return "timeout";
    case DeviceError::Kind::kDisconnected:
      return "disconnected";
    case DeviceError::Kind::kRefused:
      return "refused";
    case DeviceError::Kind::kFault:
      return "fault";
    case DeviceError::Kind::kNotHomed:
      return "not homed";
    case DeviceError::Kind::kOutOfRange:
      return "out of range";
  }
  throw InternalError("unknown kind of device error");
}

}  // namespace wheatstone
