#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "core/clock.h"

namespace wheatstone {

/// Calls `on_hang` once, from a thread of its own, when nobody has called pet() for `limit` (on the
/// machine's monotonic clock): the program hangs, and what it left moving or lit has to be stopped
/// by something that does not. `on_hang` must be safe to call from any thread at any time.
class Watchdog {
 public:
  /// Throws ArgumentError unless limit > 0.
  Watchdog(Duration limit, std::function<void()> on_hang);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  void pet();
  bool has_barked() const;

 private:
  const Nanoseconds limit_ns_;
  const std::function<void()> on_hang_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  Nanoseconds petted_ns_ = SteadyClock().now_ns();
  bool barked_ = false;
  std::jthread thread_;
};

}  // namespace wheatstone
