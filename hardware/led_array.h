#pragma once

#include <opencv2/core.hpp>

#include "hardware/device.h"

namespace wheatstone {

/// Linear light output of every LED, R, G, B, 0 = off, 1 = full. Row 0 hangs at the back wall,
/// column 0 at the left seen from the viewer.
struct LedFrame {
  cv::Mat3f drive;
};

/// The ceiling of the box.
class LedArray : public Device {
 public:
  virtual int rows() const = 0;
  virtual int columns() const = 0;
  /// Shows the whole frame or leaves the one before: never half of it. Returns when it shows, as
  /// far as the device can tell. Throws kOutOfRange: another size, a drive outside [0, 1] or not a
  /// number, or more light in all than max_mean_drive().
  virtual void set_frame(const LedFrame&, Deadline) = 0;
  /// The largest mean drive of a frame that the supply and the box allow, in (0, 1].
  virtual double max_mean_drive() const = 0;
  virtual void all_off() noexcept = 0;

  void set_all(double drive, Deadline deadline) {
    set_frame({cv::Mat3f(rows(), columns(), cv::Vec3f::all(static_cast<float>(drive)))},
              std::move(deadline));
  }
};

/// Over LEDs and channels, summed in double precision.
double mean_drive(const LedFrame&);
/// Throws DeviceError kOutOfRange, naming the first LED, for what set_frame() must refuse.
void require_valid(const LedArray&, const LedFrame&);

}  // namespace wheatstone
