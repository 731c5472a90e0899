#pragma once
// Where an observer sees points of the box on the displays.

#include "core/dataset.h"
#include "hardware/rig.h"

namespace wheatstone {

/// Asks the observer to align a mark of every display with the four near crosses and the four
/// marker LEDs, each `settings` times, and writes the means to alignments.json.
/// Errors: ArgumentError unless settings >= 1; DeviceError; FileError.
void record_alignments(const Rig&, const Dataset&, int settings = 5);

}  // namespace wheatstone
