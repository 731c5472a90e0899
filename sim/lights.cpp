#include "sim/lights.h"

#include "core/error.h"

namespace wheatstone {

void SimulatedMarkers::set(Mask mask, Deadline deadline) {
  if (mask & ~all()) {
    throw DeviceError(DeviceError::Kind::kOutOfRange,
                      "a marker beyond the " + std::to_string(count()) + " there are was asked for",
                      "use bits 0 to " + std::to_string(count() - 1));
  }
  meet(deadline);
  world_.light.marker_mask = mask;
}

MarkerLights::Mask SimulatedMarkers::state(Deadline deadline) {
  meet(deadline);
  return world_.light.marker_mask;
}

void SimulatedMarkers::meet(const Deadline& deadline) {
  world_.faults.meet("markers", deadline);
  if (world_.clock.now_ns() >= deadline.at_ns)
    throw DeviceError(DeviceError::Kind::kTimeout, "the markers were asked too late",
                      "give them more time");
}

void SimulatedLeds::set_frame(const LedFrame& frame, Deadline deadline) {
  require_valid(*this, frame);
  world_.faults.meet("leds", deadline);
  world_.light.led_drive = mean_drive(frame);
}

}  // namespace wheatstone
