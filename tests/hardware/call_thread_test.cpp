#include "hardware/still/call_thread.h"

#include <gmock/gmock.h>

#include <atomic>
#include <future>
#include <thread>

#include "hardware/device_error.h"

namespace wheatstone {
namespace {

Deadline in(double seconds, std::stop_token stop = {}) {
  return SteadyClock().in(Duration::of(seconds), std::move(stop));
}
const CallThread::Call kNothing = [](const std::stop_token&) {};

/// A call that ends when it is let go, or asked to stop.
struct Endless {
  std::promise<void> release;
  std::atomic<bool> asked_to_stop = false;
  CallThread::Call call() {
    return [this, released = release.get_future().share()](const std::stop_token& stop) {
      while (released.wait_for(std::chrono::milliseconds(1)) != std::future_status::ready)
        if (stop.stop_requested()) asked_to_stop = true;
    };
  }
};

TEST(CallThread, MakesCallsOneAfterTheOtherOnOneThread) {
  CallThread thread("device");
  std::thread::id first, second;
  thread.run([&](const std::stop_token&) { first = std::this_thread::get_id(); }, in(5));
  thread.run([&](const std::stop_token&) { second = std::this_thread::get_id(); }, in(5));
  EXPECT_EQ(first, second);
  EXPECT_NE(first, std::this_thread::get_id());
}

TEST(CallThread, HandsErrorsOver) {
  CallThread thread("device");
  const auto failing = [](const std::stop_token&) { throw ArgumentError("no", "yes"); };
  EXPECT_THROW(thread.run(failing, in(5)), ArgumentError);
  thread.run(kNothing, in(5));
}

TEST(CallThread, LetsGoOfACallAtTheDeadline) {
  Endless endless;
  CallThread thread("device");
  try {
    thread.run(endless.call(), in(0.05));
    FAIL();
  } catch (const DeviceError& e) {
    EXPECT_EQ(e.kind(), DeviceError::Kind::kTimeout);
    EXPECT_THAT(e.what(), testing::HasSubstr("device"));
  }
  EXPECT_THROW(thread.run(kNothing, in(0.05)), DeviceError) << "the first call goes on";
  endless.release.set_value();
  thread.run(kNothing, in(5));
  EXPECT_TRUE(endless.asked_to_stop);
}

TEST(CallThread, StopsWaitingWhenAskedTo) {
  for (const bool by_token : {true, false}) {
    Endless endless;
    CallThread thread("device");
    std::stop_source stop;
    const std::jthread hand([&] {
      SteadyClock().wait_until(in(0.05).at_ns);
      if (by_token)
        stop.request_stop();
      else
        thread.interrupt();
    });
    EXPECT_THROW(thread.run(endless.call(), in(9, stop.get_token())), Cancelled);
    endless.release.set_value();
    thread.run(kNothing, in(5));
  }
}

TEST(CallThread, MakesItsLastCallAlsoAfterOneThatGoesOn) {
  Endless endless;
  const auto last = std::make_shared<std::promise<void>>();
  {
    CallThread thread("device");
    EXPECT_THROW(thread.run(endless.call(), in(0.02)), DeviceError);
    thread.finish([last](const std::stop_token&) { last->set_value(); }, Duration::of(0.02));
  }
  endless.release.set_value();
  EXPECT_EQ(last->get_future().wait_for(std::chrono::seconds(5)), std::future_status::ready);
}

}  // namespace
}  // namespace wheatstone
