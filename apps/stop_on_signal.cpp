#include "apps/stop_on_signal.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

namespace wheatstone::apps {
namespace {

constexpr std::uint64_t kSignal = 1, kEnd = 1ULL << 32;  // an eventfd adds them up
volatile std::sig_atomic_t g_wake = -1;                  // all that a handler may touch
constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};

void on_signal(int signal) {
  const int before = errno;
  std::signal(signal, SIG_DFL);
  [[maybe_unused]] const ssize_t n = ::write(g_wake, &kSignal, sizeof kSignal);
  errno = before;
}

}  // namespace

StopOnSignal::StopOnSignal() : wake_(::eventfd(0, EFD_CLOEXEC)) {
  // A handler may not ask a stop_source; a thread that waits for it may.
  watcher_ = std::thread([this] {
    for (std::uint64_t seen = 0; seen < kEnd;) {
      if (::read(wake_, &seen, sizeof seen) != sizeof seen) continue;
      if (seen % kEnd != 0) source_.request_stop();
    }
  });
  g_wake = wake_;
  for (const int s : kSignals) std::signal(s, on_signal);
}

StopOnSignal::~StopOnSignal() {
  for (const int s : kSignals) std::signal(s, SIG_DFL);
  [[maybe_unused]] const ssize_t n = ::write(wake_, &kEnd, sizeof kEnd);
  watcher_.join();
  ::close(wake_);
}

}  // namespace wheatstone::apps
