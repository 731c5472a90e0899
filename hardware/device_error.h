#pragma once
// What can go wrong with a device: a closed set, so that callers can decide between retry and give
// up. A request to stop is no error of the device; it throws Cancelled.

#include <string>

#include "core/error.h"

namespace wheatstone {

/// A device that did not do what it was asked. The device's state is unchanged unless said.
class DeviceError : public Error {
 public:
  enum class Kind {
    kNotFound,      // no such device here
    kBusy,          // somebody else has it
    kPermission,    // the operating system does not let us
    kTimeout,       // no answer within the deadline
    kDisconnected,  // it was there and is gone; sticky
    kProtocol,      // it sends bytes that we do not understand
    kRefused,       // it understands and does not do it now
    kFault,         // it says that it is broken, or does something else than it was asked
    kOutOfRange,    // an argument outside what the device allows; nothing was sent
    kNotReady,      // not homed, not configured, not started
    kTooBright,     // more light than can be measured
    kTooDark,       // less light than can be measured
  };

  DeviceError(Kind kind, const std::string& problem, const std::string& remedy)
      : Error(problem, remedy), kind_(kind) {}
  Kind kind() const { return kind_; }

 private:
  Kind kind_;
};

std::string to_string(DeviceError::Kind);  // "timeout", "disconnected", ...

}  // namespace wheatstone
