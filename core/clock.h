#pragma once
// Time is handed in, so that a test never sleeps.

#include <cstdint>
#include <stop_token>
#include <string>
#include <utility>

#include "core/units.h"

namespace wheatstone {

/// Nanoseconds since an arbitrary start; never goes back.
using Nanoseconds = std::int64_t;

/// When a blocking call gives up: at a point in time, or within 50 ms of a request to stop (it then
/// throws Cancelled).
struct Deadline {
  Nanoseconds at_ns = 0;
  std::stop_token cancel = {};
};

class Clock {
 public:
  virtual ~Clock() = default;
  virtual Nanoseconds now_ns() const = 0;
  /// Returns at or after `at_ns`.
  virtual void wait_until(Nanoseconds at_ns) = 0;

  Deadline in(Duration d, std::stop_token cancel = {}) const {
    return {now_ns() + static_cast<Nanoseconds>(d.value() * 1e9), std::move(cancel)};
  }
};

/// The machine's monotonic clock.
class SteadyClock final : public Clock {
 public:
  Nanoseconds now_ns() const override;
  void wait_until(Nanoseconds at_ns) override;
};

/// A clock that moves only when somebody waits on it.
class SimulatedClock final : public Clock {
 public:
  Nanoseconds now_ns() const override { return now_ns_; }
  void wait_until(Nanoseconds at_ns) override {
    if (at_ns > now_ns_) now_ns_ = at_ns;
  }

 private:
  Nanoseconds now_ns_ = 0;
};

/// Patience with something that should take `expected`: twice as long, and half a minute.
inline Deadline deadline_for(const Clock& clock, Duration expected, std::stop_token cancel = {}) {
  return clock.in(2 * expected + Duration::of(30), std::move(cancel));
}

/// The wall clock, "2026-11-25T12:33:29Z", for records that people read.
std::string utc_timestamp();

}  // namespace wheatstone
