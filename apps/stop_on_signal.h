#pragma once

#include <csignal>
#include <stop_token>
#include <thread>

namespace wheatstone::apps {

/// While it lives, the first Ctrl-C (SIGINT), SIGTERM or SIGHUP only asks the program to stop at
/// the next safe place; the second one ends it at once. One at a time.
class StopOnSignal {
 public:
  StopOnSignal();
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

  std::stop_token token() const { return source_.get_token(); }

 private:
  int wake_ = -1;  // eventfd
  std::stop_source source_;
  std::thread watcher_;
};

}  // namespace wheatstone::apps
