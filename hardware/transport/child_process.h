#pragma once
// Another program that does one job and ends.

#include <string>
#include <vector>

#include "core/clock.h"
#include "hardware/device_error.h"

namespace wheatstone {

struct ChildResult {
  int exit_status = 0;  // 128 + the number of the signal that ended it
  std::string output;   // standard output and standard error as they came
};

/// Runs a program (looked up in PATH if its name has no slash) without input and without a terminal
/// until it ends. Whatever happens, neither it nor a child of its process group outlives the call.
/// `what` names it in errors.
/// Throws DeviceError kNotFound or kPermission if it cannot be started, kTimeout, kProtocol for
/// output beyond 1 MB; Cancelled.
ChildResult run_child(const std::string& what, const std::vector<std::string>& command,
                      const Deadline&);

}  // namespace wheatstone
