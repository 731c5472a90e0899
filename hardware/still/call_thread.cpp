#include "hardware/still/call_thread.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "hardware/device_error.h"

namespace wheatstone {
namespace {

std::chrono::steady_clock::time_point point(Nanoseconds at_ns) {
  return std::chrono::steady_clock::time_point(std::chrono::nanoseconds(at_ns));
}

}  // namespace

struct CallThread::State {
  // What one call came to; outlives the caller that gave up.
  struct Outcome {
    bool done = false;
    std::exception_ptr error;
    std::stop_source nobody_waits;
  };
  struct Job {
    Call call;
    std::shared_ptr<Outcome> outcome;
  };

  std::mutex mutex;
  std::condition_variable_any changed;
  std::optional<Job> job;
  std::shared_ptr<Outcome> current;  // of the call that goes on
  bool ending = false, gone = false, interrupted = false;

  void abandon_current() {
    if (current) current->nobody_waits.request_stop();
  }
};

CallThread::CallThread(std::string what)
    : what_(std::move(what)), state_(std::make_shared<State>()) {
  std::thread([state = state_] { loop(state); }).detach();
}

void CallThread::loop(const std::shared_ptr<State>& state) {
  std::unique_lock lock(state->mutex);
  for (;;) {
    state->changed.wait(lock, [&] { return state->job || state->ending; });
    if (!state->job) break;
    State::Job job = *std::exchange(state->job, std::nullopt);
    state->current = job.outcome;
    lock.unlock();
    std::exception_ptr error;
    try {
      job.call(job.outcome->nobody_waits.get_token());
    } catch (...) {
      error = std::current_exception();
    }
    job.call = nullptr;  // what it owns goes here, on this thread
    lock.lock();
    job.outcome->done = true;
    job.outcome->error = error;
    state->current.reset();
    state->changed.notify_all();
  }
  state->gone = true;
  state->changed.notify_all();
}

void CallThread::run(const Call& call, const Deadline& deadline) {
  std::unique_lock lock(state_->mutex);
  state_->interrupted = false;
  const auto wait = [&](const auto& met) {
    state_->changed.wait_until(lock, deadline.cancel, point(deadline.at_ns),
                               [&] { return state_->interrupted || met(); });
    if (met()) return;
    state_->abandon_current();
    if (state_->interrupted || deadline.cancel.stop_requested())
      throw Cancelled("the " + what_ + " was asked to stop");
    throw DeviceError(DeviceError::Kind::kTimeout, "the " + what_ + " did not answer in time",
                      "see that it is on and awake, then run the command again");
  };
  wait([&] { return !state_->current && !state_->job; });
  const auto outcome = std::make_shared<State::Outcome>();
  state_->job = State::Job{call, outcome};
  state_->changed.notify_all();
  try {
    wait([&] { return outcome->done; });
  } catch (const Error&) {
    outcome->nobody_waits.request_stop();
    throw;
  }
  if (outcome->error) std::rethrow_exception(outcome->error);
}

void CallThread::interrupt() noexcept {
  const std::lock_guard lock(state_->mutex);
  state_->interrupted = true;
  state_->changed.notify_all();
}

void CallThread::finish(const Call& last, Duration patience) noexcept {
  std::unique_lock lock(state_->mutex);
  state_->abandon_current();
  state_->job = State::Job{last, std::make_shared<State::Outcome>()};
  state_->ending = true;
  state_->changed.notify_all();
  state_->changed.wait_for(lock, std::chrono::duration<double>(patience.value()),
                           [&] { return state_->gone; });
}

CallThread::~CallThread() {
  const std::lock_guard lock(state_->mutex);
  state_->abandon_current();
  state_->ending = true;
  state_->changed.notify_all();
}

}  // namespace wheatstone
