#pragma once
// ResourceWatch for drivers on devices that umockdev emulates.

#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <iterator>
#include <thread>

#include "core/clock.h"
#include "tests/contract/resources.h"

namespace wheatstone {

inline std::ptrdiff_t open_handles() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
}

/// Root may open everything: the call that shall be refused is made as nobody. All threads of the
/// process are nobody meanwhile, also to access().
class AsNobody {
 public:
  AsNobody() {
    if (root_ && ::setresuid(kNobody, kNobody, 0) != 0) ADD_FAILURE() << "root for ever";
  }
  ~AsNobody() {
    if (root_ && ::setresuid(0, 0, 0) != 0) ADD_FAILURE() << "nobody for ever";
  }
  AsNobody(const AsNobody&) = delete;
  AsNobody& operator=(const AsNobody&) = delete;

 private:
  static constexpr uid_t kNobody = 65534;
  bool root_ = ::geteuid() == 0;
};

/// Waits till the emulation, which is slow to notice that a client is gone, has let go of it.
inline void settle_handles() {
  SteadyClock clock;
  for (std::ptrdiff_t before = -1, now = open_handles(); now != before;) {
    before = now;
    clock.wait_until(clock.now_ns() + 60'000'000);
    now = open_handles();
  }
}

/// ResourceWatch, once the emulation has noticed that its client is gone.
class MockResources {
 public:
  explicit MockResources(double busy_s) : watch_(busy_s) {}
  ~MockResources() {
    const SteadyClock clock;
    const Nanoseconds end = clock.in(Duration::of(1)).at_ns;
    while (open_handles() > before_ && clock.now_ns() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

 private:
  ResourceWatch watch_;
  std::ptrdiff_t before_ = open_handles();
};

}  // namespace wheatstone
