#pragma once

#include "core/clock.h"
#include "core/image.h"
#include "core/rig_types.h"
#include "core/units.h"

namespace wheatstone {

/// One exposure as the sensor read it.
struct RawFrame {
  MosaicImage mosaic;
  Duration exposure;
};

/// The capture camera at ISO 100.
class StillCamera {
 public:
  virtual ~StillCamera() = default;
  virtual const CameraProfile& profile() const = 0;
  /// Takes one frame. Throws DeviceError (kOutOfRange, kTimeout, kDisconnected).
  virtual RawFrame expose(Duration, Deadline) = 0;
};

}  // namespace wheatstone
