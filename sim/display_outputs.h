#pragma once
// The nine video outputs of the rig's machine, without the machine.

#include <vector>

#include "hardware/display_outputs.h"
#include "hardware/rig_file/driver_catalogue.h"
#include "sim/world.h"

namespace wheatstone {

/// An LCD and a projector for each of the four displays, and the operator's screen; projectors
/// share one EDID, as cheap panels do. A test may change `outputs` as a hand at the cables would.
class SimulatedDisplayOutputs final : public DisplayOutputs {
 public:
  /// Nothing goes wrong with them.
  SimulatedDisplayOutputs();
  /// The faults are this world's.
  explicit SimulatedDisplayOutputs(World&);

  DeviceIdentity identity() const override {
    return {"simulated", "twin of the video outputs", "", "", ""};
  }
  std::vector<DisplayOutput> enumerate(Deadline) override;
  void neutralise(Deadline) override;

  std::vector<DisplayOutput> outputs;

 private:
  FaultScript* faults_ = nullptr;
};

/// What a rig file would say of them.
std::vector<WantedOutput> wanted_simulated_outputs();

/// Driver "simulated" of the rig file's [display_outputs]. Unlike the twin's other devices they can
/// be opened by themselves: nothing in the world depends on them.
void add_simulated_outputs_driver(DriverCatalogue&);

}  // namespace wheatstone
