#pragma once
// A photodiode on the top left corner of a display.

#include <cstdint>
#include <vector>

#include "hardware/light_sensor.h"
#include "sim/world.h"

namespace wheatstone {

inline constexpr double kPhotodiodeSamplesPerS = 10'000;
inline constexpr double kPhotodiodeFullScale = 1.25;  // of the display's peak: 1 is never reached

/// What the diode gives: 16-bit samples, with noise from the world's seed. The displays of the
/// twin hold still, and so does the light while it is recorded.
class PhotodiodeModel {
 public:
  /// `gain`: above 1 it saturates on a white corner.
  PhotodiodeModel(World& world, DisplayId id, double gain = 1)
      : world_(world), id_(id), gain_(gain) {}
  /// Of the n-th recording.
  std::vector<std::uint16_t> samples(std::size_t count, std::uint64_t recording) const;

 private:
  World& world_;
  DisplayId id_;
  double gain_;
};

class SimulatedLightSensor final : public LightSensor {
 public:
  SimulatedLightSensor(World& world, DisplayId id, double gain = 1)
      : world_(world), diode_(world, id, gain) {}

  DeviceIdentity identity() const override {
    return {"simulated", "twin of the photodiode", "", "", ""};
  }
  /// At most 1000 s.
  LightTrace record(Duration, Deadline) override;

 private:
  World& world_;
  PhotodiodeModel diode_;
  std::uint64_t recordings_ = 0;
};

}  // namespace wheatstone
