#pragma once
// What a driver may not leave behind, and how much it may work while it waits.

#include <gtest/gtest.h>

#include <ctime>
#include <filesystem>
#include <iterator>
#include <thread>

namespace wheatstone {

/// Expects that no handle and no thread is left when it goes, and that the process was not busy
/// for more than `busy_s` and a quarter of the time that passed.
class ResourceWatch {
 public:
  explicit ResourceWatch(double busy_s = 0.1) : busy_s_(kInstrumented * busy_s) {}
  ~ResourceWatch() {
    const double busy = seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu_s_;
    EXPECT_LE(busy, busy_s_ + 0.25 * (seconds(CLOCK_MONOTONIC) - start_s_)) << "busy waiting";
    EXPECT_LE(count("/proc/self/fd"), handles_ + pardoned_) << "a handle is left open";
    // The kernel takes a moment to clear away a thread that was joined.
    const double end_s = seconds(CLOCK_MONOTONIC) + 1;
    while (count("/proc/self/task") > threads_ && seconds(CLOCK_MONOTONIC) < end_s)
      std::this_thread::yield();
    EXPECT_EQ(count("/proc/self/task"), threads_) << "a thread is left running";
  }
  /// So many handles are left open by what is not ours.
  void pardon_handles(std::ptrdiff_t handles) { pardoned_ += handles; }
  ResourceWatch(const ResourceWatch&) = delete;
  ResourceWatch& operator=(const ResourceWatch&) = delete;

 private:
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  static constexpr double kInstrumented = 8;  // checked code works several times as long
#else
  static constexpr double kInstrumented = 1;
#endif

  static std::ptrdiff_t count(const char* folder) {
    return std::distance(std::filesystem::directory_iterator(folder), {});
  }
  static double seconds(clockid_t clock) {
    timespec t{};
    ::clock_gettime(clock, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }

  double busy_s_;
  std::ptrdiff_t pardoned_ = 0;
  std::ptrdiff_t handles_ = count("/proc/self/fd"), threads_ = count("/proc/self/task");
  double cpu_s_ = seconds(CLOCK_PROCESS_CPUTIME_ID), start_s_ = seconds(CLOCK_MONOTONIC);
};

}  // namespace wheatstone
