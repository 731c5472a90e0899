#pragma once
// The rig that a command works on: opened from a rig file, or the twin.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hardware/rig_file/rig_file.h"
#include "sim/simulated_rig.h"

namespace wheatstone::apps {

class RigSource {
 public:
  /// The twin, with all its devices.
  explicit RigSource(const SimulatedRigOptions&);
  /// The devices of the rig file; what goes over their wires is written to `transcript` if it is
  /// not empty. Throws as read_rig_file() and OpenRig.
  explicit RigSource(const RigDescription&, const std::filesystem::path& transcript = {});

  /// As long as this object lives.
  Rig rig();
  /// "simulated rig", or the rig's name.
  const std::string& name() const { return name_; }
  /// Of the twin; for real rigs scene and seed are empty and the scale is 1.
  const SimulatedRigOptions& simulation() const { return simulation_; }
  /// How long the program may hang before the rig is made safe.
  Duration watchdog() const { return watchdog_; }
  SimulatedRig* twin() { return twin_.get(); }

 private:
  std::string name_ = "simulated rig";
  SimulatedRigOptions simulation_;
  Duration watchdog_ = Duration::of(3600);  // the twin's frames may take long to compute
  RigDescription description_;
  SteadyClock clock_;
  std::unique_ptr<SimulatedRig> twin_;
  std::unique_ptr<OpenRig> open_;
};

}  // namespace wheatstone::apps
