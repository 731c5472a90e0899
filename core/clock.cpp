#include "core/clock.h"

#include <chrono>
#include <ctime>
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

std::string utc_timestamp() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

}  // namespace wheatstone
