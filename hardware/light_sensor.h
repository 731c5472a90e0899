#pragma once

#include <vector>

#include "core/units.h"
#include "hardware/device.h"

namespace wheatstone {

struct LightTrace {
  Nanoseconds start_ns = 0;  // of the first sample, on the machine's monotonic clock
  double samples_per_s = 0;
  std::vector<float> levels;  // linear in light, 0..1 of the sensor's range
};

/// A photodiode on a corner of a display, for timing.
class LightSensor : public Device {
 public:
  /// Records from now on. Throws kFault for lost samples, kTooBright where levels reach 1.
  virtual LightTrace record(Duration, Deadline) = 0;
};

}  // namespace wheatstone
