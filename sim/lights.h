#pragma once
// The simulated lights of the box.

#include "hardware/led_array.h"
#include "hardware/marker_lights.h"
#include "sim/world.h"

namespace wheatstone {

class SimulatedMarkers final : public MarkerLights {
 public:
  explicit SimulatedMarkers(World& world) : world_(world) {}
  ~SimulatedMarkers() override { all_off(); }
  DeviceIdentity identity() const override {
    return {"simulated", "twin of the markers", "", "", ""};
  }
  int count() const override { return kMarkerCount; }
  void set(Mask, Deadline) override;
  Mask state(Deadline) override;
  void all_off() noexcept override { world_.light.marker_mask = 0; }

 private:
  void meet(const Deadline&);

  World& world_;
};

/// The box sees the mean of all drives as white light: patterns and colours do not reach it.
class SimulatedLeds final : public LedArray {
 public:
  explicit SimulatedLeds(World& world) : world_(world) {}
  DeviceIdentity identity() const override {
    return {"simulated", "twin of the ceiling", "", "", ""};
  }
  int rows() const override { return 16; }
  int columns() const override { return 16; }
  double max_mean_drive() const override { return 1; }
  void set_frame(const LedFrame&, Deadline) override;
  void all_off() noexcept override { world_.light.led_drive = 0; }

 private:
  World& world_;
};

}  // namespace wheatstone
