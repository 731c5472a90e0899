#include "apps/stop_on_signal.h"

namespace wheatstone::apps {
namespace {

volatile std::sig_atomic_t g_requested = 0;  // all that a handler may touch
constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};

void on_signal(int signal) {
  g_requested = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

StopOnSignal::StopOnSignal() {
  g_requested = 0;
  for (const int s : kSignals) std::signal(s, on_signal);
}

StopOnSignal::~StopOnSignal() {
  for (const int s : kSignals) std::signal(s, SIG_DFL);
}

bool StopOnSignal::requested() {
  return g_requested != 0;
}

}  // namespace wheatstone::apps
