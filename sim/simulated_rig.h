#pragma once
// The digital twin: every device of the rig over one simulated world.

#include <cstdint>
#include <memory>
#include <string>

#include "hardware/rig.h"
#include "sim/eye.h"
#include "sim/world.h"

namespace wheatstone {

struct SimulatedRigOptions {
  std::string scene = "card";  // one of scene_names()
  double scale = 0.25;         // of all pixel counts, in (0, 1]
  std::uint64_t seed = 7;
  double observer_noise_arcmin = 0.3;
  bool camera_noise = true;
};

/// Not thread-safe: one caller at a time. Equal options and calls give equal bytes.
class SimulatedRig {
 public:
  /// Throws ArgumentError for an unknown scene, a scale outside (0, 1] or negative noise.
  explicit SimulatedRig(const SimulatedRigOptions& options = {});
  ~SimulatedRig();
  SimulatedRig(const SimulatedRig&) = delete;
  SimulatedRig& operator=(const SimulatedRig&) = delete;

  /// The devices; they live as long as this object.
  Rig rig();
  /// The truth, for tests and for photographs from the eye.
  World& world();
  EyePhotograph eye() { return EyePhotograph(world()); }

 private:
  struct Devices;
  std::unique_ptr<Devices> devices_;
};

}  // namespace wheatstone
