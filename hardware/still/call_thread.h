#pragma once
// Calls into a library that cannot be broken off, under deadlines all the same.

#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "core/clock.h"

namespace wheatstone {

/// One thread that makes all calls, one after the other, so that a library that wants to be called
/// by one thread is. A call that outlives its deadline goes on by itself: what it uses it must own.
class CallThread {
 public:
  /// Is asked to stop when nobody waits for it any more.
  using Call = std::function<void(const std::stop_token&)>;

  /// `what` names the device in errors.
  explicit CallThread(std::string what);
  /// Returns when `last` has been made, or when it has not been within `patience`: the thread then
  /// ends by itself after the call it is in and `last`.
  void finish(const Call& last, Duration patience) noexcept;
  /// Without finish() the thread ends after the call it is in.
  ~CallThread();
  CallThread(const CallThread&) = delete;
  CallThread& operator=(const CallThread&) = delete;

  /// Waits for an earlier call that goes on, then for this one; rethrows what it throws. Throws
  /// DeviceError kTimeout, and Cancelled also after interrupt().
  void run(const Call&, const Deadline&);
  /// Lets go of the run() under way, if there is one. From any thread.
  void interrupt() noexcept;

 private:
  struct State;
  static void loop(const std::shared_ptr<State>&);

  std::string what_;
  std::shared_ptr<State> state_;
};

}  // namespace wheatstone
