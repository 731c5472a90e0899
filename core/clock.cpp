#include "core/clock.h"

#include <chrono>
#include <thread>

namespace wheatstone {

Nanoseconds SteadyClock::now_ns() const {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void SteadyClock::wait_until(Nanoseconds at_ns) {
  std::this_thread::sleep_for(std::chrono::nanoseconds(at_ns - now_ns()));
}

}  // namespace wheatstone
