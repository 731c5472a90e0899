#include "sim/lights.h"

#include "core/error.h"

namespace wheatstone {

void SimulatedMarkers::set(Mask mask, Deadline deadline) {
  if (mask & ~all()) {
    throw DeviceError(DeviceError::Kind::kOutOfRange,
                      "a marker beyond the " + std::to_string(count()) + " there are was asked for",
                      "use bits 0 to " + std::to_string(count() - 1));
  }
  world_.faults.meet("markers", deadline);
  world_.light.marker_mask = mask;
}

MarkerLights::Mask SimulatedMarkers::state(Deadline deadline) {
  world_.faults.meet("markers", deadline);
  return world_.light.marker_mask;
}

void SimulatedLeds::set_frame(const LedFrame& frame, Deadline deadline) {
  require_valid(*this, frame);
  world_.faults.meet("leds", deadline);
  world_.light.led_drive = mean_drive(frame);
}

}  // namespace wheatstone
