#pragma once

#include "core/clock.h"
#include "core/units.h"

namespace wheatstone {

/// The rail that carries the still camera. Positions run from 0 to travel().
class LinearStage {
 public:
  virtual ~LinearStage() = default;
  virtual Length travel() const = 0;
  /// How long move_to() takes over a distance >= 0 when nothing goes wrong.
  virtual Duration move_duration(Length distance) const = 0;
  /// Finds the reference end; returns the position there. Throws DeviceError.
  virtual Length home(Deadline) = 0;
  /// Moves and settles; returns the position reached as the encoder reads it. Throws DeviceError
  /// (kNotHomed, kOutOfRange, kTimeout); the carriage has not moved then.
  virtual Length move_to(Length, Deadline) = 0;
  virtual void stop() noexcept = 0;
};

}  // namespace wheatstone
