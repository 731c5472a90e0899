#pragma once

#include <limits>
#include <string>
#include <string_view>

#include "core/clock.h"

namespace wheatstone {

/// What the processor of a serial device does, without the wire: bytes in, bytes out, in time that
/// is handed in and never goes back.
class SerialFirmware {
 public:
  static constexpr Nanoseconds kNever = std::numeric_limits<Nanoseconds>::max();

  virtual ~SerialFirmware() = default;
  virtual void receive(std::string_view bytes, Nanoseconds now) = 0;
  /// Carries on until `now`; returns what it sends meanwhile.
  virtual std::string run(Nanoseconds now) = 0;
  /// When it has to be run again if nothing arrives.
  virtual Nanoseconds next_event() const = 0;
};

}  // namespace wheatstone
