#pragma once
// How calls end, for tests of contracts and faults.

#include <gmock/gmock.h>

#include <optional>
#include <string>

#include "core/clock.h"
#include "sim/faults.h"
#include "tests/contract/fault_case.h"

namespace wheatstone {

inline constexpr double kFaultDeadlineS = 0.4;

/// The fault, at a device of the twin.
inline void arm(FaultScript& faults, const std::string& device, const FaultCase& fault) {
  if (std::string(fault.fault) == "clock step")
    faults.step_clock(device, Duration::of(3600));
  else
    faults.arm(device, fault.error);
}

/// None: no DeviceError.
template <class Call>
std::optional<DeviceError::Kind> kind_of(const Call& call) {
  try {
    call();
  } catch (const DeviceError& e) {
    return e.kind();
  }
  return std::nullopt;
}

/// The call, handed a deadline on the machine's clock, ends as documented and in time; returns its
/// message.
template <class Call>
std::string expect_fault(const FaultCase& fault, const Call& call,
                         double deadline_s = kFaultDeadlineS) {
  const SteadyClock clock;
  const Nanoseconds start = clock.now_ns();
  std::string message;
  try {
    call(clock.in(Duration::of(deadline_s)));
    ADD_FAILURE() << "no error";
  } catch (const DeviceError& e) {
    message = e.what();
    EXPECT_EQ(to_string(e.kind()), to_string(fault.error)) << message;
    EXPECT_THAT(message, ::testing::HasSubstr("; ")) << "a remedy";
  }
  EXPECT_LE(static_cast<double>(clock.now_ns() - start) * 1e-9, deadline_s + 0.5);
  return message;
}

}  // namespace wheatstone
