#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/units.h"
#include "hardware/device.h"

namespace wheatstone {

/// One exposure as the sensor read it, with what the camera itself says of it.
struct RawFrame {
  MosaicImage mosaic;
  Duration exposure;
  double gain = 1;               // ISO / 100
  std::string camera_serial;     // of the body that took it
  Nanoseconds triggered_ns = 0;  // on the rig's clock
  // The camera's own file, where it makes one, and how its name ends ("ARW").
  std::vector<std::byte> file;
  std::string file_type;
};

/// The capture camera at ISO 100.
class StillCamera : public Device {
 public:
  /// The exposure the camera takes when asked for this one: the nearest it offers. Throws
  /// kOutOfRange where the nearest is further away than a sixth of a stop.
  virtual Duration offered_exposure(Duration) const = 0;
  /// How long expose() takes when nothing goes wrong.
  virtual Duration frame_duration(Duration exposure) const = 0;
  /// How many bytes the camera's own file (RawFrame::file) of so many photosites has at most; 0:
  /// it makes none.
  virtual std::uintmax_t largest_file(std::uintmax_t photosites) const = 0;
  /// Takes one frame at offered_exposure(); the shutter is closed when this returns. Throws
  /// kTimeout (the shutter may still be open), kFault (the camera took something else, or its file
  /// is damaged), kRefused (its card is full).
  virtual RawFrame expose(Duration, Deadline) = 0;
  /// Ends an exposure that is under way, where the camera can; expose() then throws Cancelled.
  virtual void abort() noexcept = 0;
};

}  // namespace wheatstone
