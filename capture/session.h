#pragma once
// Captures a light field of the box through whatever rig is plugged in.

#include <functional>
#include <string>
#include <vector>

#include "core/dataset.h"
#include "hardware/rig.h"

namespace wheatstone {

struct CapturePlan {
  int views = 11;  // evenly spaced over the rail, ends included
  std::vector<double> exposures_s = {1 / 240.0, 1 / 60.0, 1 / 15.0};
  double marker_exposure_s = 1 / 60.0;
};

/// Empty when the plan can be carried out, else the reason.
std::string validate(const CapturePlan&);

/// For each rail position: the ceiling on, one frame per exposure; the ceiling off and the markers
/// on, one marker frame. Writes raw/*.png as they come and frames.json after every view,
/// camera.json, landmarks.json and displays.json at the start. Lights are off when it returns or
/// throws. progress(done, total) after every frame. Errors: ArgumentError (plan), DeviceError,
/// FileError.
void capture_light_field(const Rig&, const Dataset&, const CapturePlan&,
                         const std::function<void(int, int)>& progress);

/// Asks the observer to align a mark of every display with the four near crosses and the four
/// marker LEDs, each `settings` times, and writes the means to alignments.json.
/// Errors: ArgumentError unless settings >= 1; DeviceError; FileError.
void record_alignments(const Rig&, const Dataset&, int settings = 5);

}  // namespace wheatstone
