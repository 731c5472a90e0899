#pragma once

#include <csignal>

namespace wheatstone::apps {

/// While it lives, the first Ctrl-C (SIGINT), SIGTERM or SIGHUP only asks the program to stop at
/// the next safe place; the second one ends it at once. One at a time.
class StopOnSignal {
 public:
  StopOnSignal();
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

  static bool requested();
};

}  // namespace wheatstone::apps
