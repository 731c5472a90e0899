#pragma once
// What shall go wrong with the devices of the twin, and when.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/random.h"
#include "hardware/device_error.h"

namespace wheatstone {

/// How often something goes wrong, by the name of a profile: "rare" (one call in 500), "often" (one
/// in 50). Throws ArgumentError for others.
double fault_probability(const std::string& profile);

/// Every call of a simulated device that talks to it asks meet() first. Devices have the names of
/// Rig's members: "stage", "markers", "leds", "camera", ...
class FaultScript {
 public:
  explicit FaultScript(Clock& clock) : clock_(clock) {}

  /// The call of `device` after `skipped` further ones ends with this error.
  void arm(const std::string& device, DeviceError::Kind, int skipped = 0);
  /// The clock steps forward in the call of `device` after `skipped` further ones, as when the
  /// machine was asleep; the call ends with kTimeout if its deadline is over by then.
  void step_clock(const std::string& device, Duration by, int skipped = 0);
  /// From now on every call of every device fails with this probability, in the way a real one
  /// would: a time-out, a lost connection, nonsense, a refusal, an hour of sleep. Throws
  /// ArgumentError unless 0 <= probability <= 1.
  void arm_at_random(double probability, std::uint64_t seed);
  /// The cable is in again; devices work as new objects would.
  void reconnect(const std::string& device) { gone_.erase(device); }

  /// Throws what is due: kTimeout at the deadline, all others at once; Cancelled if asked to stop.
  void meet(const std::string& device, const Deadline&);

 private:
  struct Armed {
    std::string device;
    std::optional<DeviceError::Kind> kind;  // none: the clock steps
    Duration step;
    int skipped;
  };

  [[noreturn]] void fail(const std::string& device, DeviceError::Kind, const Deadline&);
  void sleep(const std::string& device, Duration, const Deadline&);

  Clock& clock_;
  std::vector<Armed> armed_;
  std::map<std::string, bool> gone_;
  double probability_ = 0;
  RandomStream random_{0, 0};
};

}  // namespace wheatstone
