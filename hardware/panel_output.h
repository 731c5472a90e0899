#pragma once

#include "core/clock.h"
#include "core/image.h"
#include "core/rig_types.h"

namespace wheatstone {

/// One modulator of one display: an LCD (CV_8UC3 drive) or its projector (CV_8UC1 drive).
class PanelOutput {
 public:
  enum class Modulator { kLcd, kProjector };

  /// When a frame was asked for and when it was on the panel; late: it missed its refresh.
  struct PresentRecord {
    Nanoseconds asked_ns = 0, achieved_ns = 0;
    bool late = false;
  };

  virtual ~PanelOutput() = default;
  virtual DisplayId id() const = 0;
  virtual Modulator modulator() const = 0;
  virtual int width_px() const = 0;
  virtual int height_px() const = 0;
  /// Shows the frame from the first refresh at or after `at` on, and returns when it is visible.
  /// Throws DeviceError kRefused for an image of another size or type; kTimeout, kDisconnected.
  virtual PresentRecord show(const DriveImage&, Nanoseconds at) = 0;
  /// Shows the darkest there is, from the next refresh on. Any thread, any time.
  virtual void go_dark() noexcept = 0;
};

}  // namespace wheatstone
