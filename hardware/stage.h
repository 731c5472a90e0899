#pragma once
// One motorised axis: the rail that carries the still camera, or the platform that turns the box.

#include <string>

#include "core/units.h"
#include "hardware/device.h"

namespace wheatstone {

enum class StageState {
  kUnknown,  // does not know where it stands: only home() is accepted, all else is kNotReady
  kIdle,     // stands at position()
  kMoving,
  kFault,  // the device needs a person; home() may be tried
};
std::string to_string(StageState);

/// Positions run from 0 at the home end to travel(), whatever the controller's own signs. P is
/// Length (mm along the rail) or Angle (rad).
template <class P>
class Stage : public Device {
 public:
  virtual P travel() const = 0;
  /// The smallest step that can be commanded.
  virtual P resolution() const = 0;
  /// How long move_to() takes over a distance >= 0 when nothing goes wrong.
  virtual Duration move_duration(P distance) const = 0;
  /// At most, from anywhere; for deadlines.
  virtual Duration home_duration() const = 0;
  /// As far as is known without asking the device.
  virtual StageState state() const = 0;

  /// Finds the reference end; returns the position there. A failed or cancelled home() leaves
  /// kUnknown or kFault.
  virtual P home(Deadline) = 0;
  /// Moves to the nearest step and settles; returns where it then stands: as an encoder reads it,
  /// or as commanded where there is none (position_is_measured()). Nothing is sent for kNotReady
  /// and kOutOfRange. kTimeout, kFault, kDisconnected and Cancelled leave the carriage standing
  /// where the device can be stopped, and kUnknown where the position may be lost.
  virtual P move_to(P, Deadline) = 0;
  virtual P position(Deadline) = 0;
  virtual bool position_is_measured() const = 0;
  /// Stands as soon as the device allows. A move that was under way ends with kRefused. What cannot
  /// be stopped ends its move first; a request to stop is then seen after it.
  virtual void stop() noexcept = 0;
};

using LinearStage = Stage<Length>;
using RotaryStage = Stage<Angle>;

}  // namespace wheatstone
