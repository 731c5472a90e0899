#pragma once
// The table of faults: what a driver does when something goes wrong. docs/hardware/faults.md is
// generated from all of them (fault_table_test.cpp), and each is carried out by its driver's test.

#include <algorithm>
#include <ostream>
#include <string>

#include "hardware/device_error.h"

namespace wheatstone {

struct FaultCase {
  const char* driver;  // "grbl", "hid relay", "simulated", ...
  const char* fault;   // "silence", "garbage", "half a line", "unplugged", ...
  const char* state;   // what the device was asked for or doing: "homing", "moving", "idle", ...
  DeviceError::Kind error;  // how the call ends
  const char* after;        // what the device object then says of itself: "unknown", "dark", ...
};

/// For test names: letters and digits only.
inline std::string test_name(const FaultCase& c) {
  std::string name = std::string(c.driver) + "_" + c.fault + "_" + c.state;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char ch) { return !std::isalnum(ch); }, '_');
  return name;
}
inline void PrintTo(const FaultCase& c, std::ostream* out) {
  *out << c.driver << ", " << c.fault << " while " << c.state;
}

}  // namespace wheatstone
