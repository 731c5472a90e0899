#include "hardware/device_error.h"

namespace wheatstone {

std::string to_string(DeviceError::Kind kind) {
  switch (kind) {
    case DeviceError::Kind::kNotFound:
      return "not found";
    case DeviceError::Kind::kBusy:
      return "busy";
    case DeviceError::Kind::kPermission:
      return "permission";
    case DeviceError::Kind::kTimeout:
      return "timeout";
    case DeviceError::Kind::kDisconnected:
      return "disconnected";
    case DeviceError::Kind::kProtocol:
      return "protocol";
    case DeviceError::Kind::kRefused:
      return "refused";
    case DeviceError::Kind::kFault:
      return "fault";
    case DeviceError::Kind::kOutOfRange:
      return "out of range";
    case DeviceError::Kind::kNotReady:
      return "not ready";
    case DeviceError::Kind::kTooBright:
      return "overexposed";
    case DeviceError::Kind::kTooDark:
      return "underexposed";
  }
  throw InternalError("unknown kind of device error");
}

}  // namespace wheatstone
