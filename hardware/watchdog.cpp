#include "hardware/watchdog.h"

#include <chrono>
#include <utility>

#include "core/error.h"

namespace wheatstone {

Watchdog::Watchdog(Duration limit, std::function<void()> on_hang)
    : limit_ns_(static_cast<Nanoseconds>(limit.value() * 1e9)), on_hang_(std::move(on_hang)) {
  if (!(limit.value() > 0))
    throw ArgumentError("a watchdog's limit is not above 0 s", "use for example 120");
  thread_ = std::jthread([this](const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
      const Nanoseconds left = petted_ns_ + limit_ns_ - SteadyClock().now_ns();
      if (left > 0 || barked_) {
        changed_.wait_for(lock, stop, std::chrono::nanoseconds(barked_ ? limit_ns_ : left),
                          [] { return false; });
        continue;
      }
      barked_ = true;
      lock.unlock();
      on_hang_();
      lock.lock();
    }
  });
}

Watchdog::~Watchdog() = default;

void Watchdog::pet() {
  const std::lock_guard lock(mutex_);
  petted_ns_ = SteadyClock().now_ns();
}

bool Watchdog::has_barked() const {
  const std::lock_guard lock(mutex_);
  return barked_;
}

}  // namespace wheatstone
