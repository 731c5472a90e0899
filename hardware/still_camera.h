#pragma once

#include <string>

#include "core/clock.h"
#include "core/image.h"
#include "core/rig_types.h"
#include "core/units.h"

namespace wheatstone {

/// One exposure as the sensor read it, with what the camera itself says of it.
struct RawFrame {
  MosaicImage mosaic;
  Duration exposure;
  double gain = 1;               // ISO / 100
  std::string camera_serial;     // of the body that took it
  Nanoseconds triggered_ns = 0;  // on the rig's clock
};

/// The capture camera at ISO 100.
class StillCamera {
 public:
  virtual ~StillCamera() = default;
  virtual const CameraProfile& profile() const = 0;
  /// How long expose() takes when nothing goes wrong.
  virtual Duration frame_duration(Duration exposure) const = 0;
  /// Takes one frame; the shutter is closed when this returns. Throws DeviceError (kOutOfRange,
  /// kTimeout: the shutter may still be open; kDisconnected).
  virtual RawFrame expose(Duration, Deadline) = 0;
};

}  // namespace wheatstone
