#pragma once
// An observer in a chin rest, and a tracker that looks at them.

#include <cstdint>

#include "hardware/head_tracker.h"
#include "sim/world.h"

namespace wheatstone {

inline constexpr double kTrackerSamplesPerS = 60;
inline constexpr Nanoseconds kTrackerDelayNs = 12'000'000;  // from exposure to sending
inline constexpr double kTrackerSigmaMm = 0.1;              // sideways and upwards
inline constexpr double kTrackerSigmaDepthMm = 0.4;

/// Sways by about a millimetre, turns a little with it, and blinks every few seconds; all from the
/// seed and the time alone.
class SwayingHead {
 public:
  explicit SwayingHead(std::uint64_t seed) : seed_(seed) {}
  Eigen::Vector3d eye_rsb_mm(Eye, Nanoseconds) const;
  bool eyes_closed(Nanoseconds) const;
  /// What the tracker measures in its sample of this number, exposed at exposed_ns(number).
  std::array<std::optional<EyeCentre>, 2> measured(std::uint32_t number) const;
  static Nanoseconds exposed_ns(std::uint32_t number);

 private:
  Eigen::Vector3d sway(Nanoseconds, std::uint64_t what) const;

  std::uint64_t seed_;
};

class SimulatedHeadTracker final : public HeadTracker {
 public:
  explicit SimulatedHeadTracker(World& world) : world_(world), head_(world.seed) {}

  DeviceIdentity identity() const override {
    return {"simulated", "twin of the head tracker", "SIM-TRACKER", "", ""};
  }
  EyeCentres next(Deadline) override;

 private:
  World& world_;
  SwayingHead head_;
  std::int64_t last_ = -1;  // number of the sample handed out
};

}  // namespace wheatstone
