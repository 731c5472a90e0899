#pragma once
// The controls of a V4L2 camera: everything automatic off, then exposure and gain.

#include <cstdint>

#include "core/clock.h"
#include "hardware/video/v4l2_node.h"

namespace wheatstone {

/// Automatic exposure, gain, white balance and focus off, each read back; sharpening, backlight
/// compensation and mains filter as low as they go. What the camera lacks is skipped. Throws kFault
/// if something stays automatic.
void switch_automatics_off(V4l2Node&, const Deadline&);

/// Throws kOutOfRange, and nothing is set, if the camera has limits and one value is beyond them.
void require_within_limits(V4l2Node&, Duration exposure, double gain, const Deadline&);

/// Both return what the camera then says; 0 where it lacks the control.
Duration set_exposure(V4l2Node&, Duration, const Deadline&);
double set_gain(V4l2Node&, double gain, const Deadline&);

}  // namespace wheatstone
