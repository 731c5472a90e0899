#pragma once
// The nine video outputs of the rig's machine, without the machine.

#include <vector>

#include "hardware/display_outputs.h"
#include "sim/world.h"

namespace wheatstone {

/// An LCD and a projector for each of the four displays, and the operator's screen; projectors
/// share one EDID, as cheap panels do. A test may change `outputs` as a hand at the cables would.
class SimulatedDisplayOutputs final : public DisplayOutputs {
 public:
  explicit SimulatedDisplayOutputs(World& world);

  DeviceIdentity identity() const override {
    return {"simulated", "twin of the video outputs", "", "", ""};
  }
  std::vector<DisplayOutput> enumerate(Deadline) override;
  void neutralise(Deadline) override;

  std::vector<DisplayOutput> outputs;

 private:
  World& world_;
};

/// What a rig file would say of them.
std::vector<WantedOutput> wanted_simulated_outputs();

}  // namespace wheatstone
