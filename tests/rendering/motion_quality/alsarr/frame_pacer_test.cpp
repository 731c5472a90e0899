#include "rendering/motion_quality/alsarr/frame_pacer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "core/random.h"

namespace wheatstone {
namespace {

/// Wakes late by a fixed time, as real clocks do.
class SluggishClock final : public Clock {
 public:
  explicit SluggishClock(Nanoseconds delay_ns) : delay_ns_(delay_ns) {}
  Nanoseconds now_ns() const override { return now_ns_; }
  void wait_until(Nanoseconds at_ns) override {
    if (at_ns > now_ns_) now_ns_ = at_ns + delay_ns_;
  }
  void work(Nanoseconds ns) { now_ns_ += ns; }

 private:
  Nanoseconds delay_ns_, now_ns_ = 1000;
};

TEST(FramePacer, HoldsTheRateWhateverTheWorkTakes) {
  SimulatedClock clock;
  FramePacer pacer(clock, 85);
  RandomStream random(1, 0);
  const Nanoseconds interval_ns = std::llround(1e9 / 85);
  for (int i = 0; i < 500; ++i) {
    const PacedFrame frame = pacer.next_frame();
    EXPECT_EQ(frame.started_ns, i * interval_ns);
    EXPECT_EQ(frame.due_ns, frame.started_ns);
    EXPECT_FALSE(frame.late);
    clock.wait_until(clock.now_ns() +
                     static_cast<Nanoseconds>(random.uniform() * static_cast<double>(interval_ns)));
  }
  const PacingReport report = pacer.report();
  EXPECT_EQ(report.frames, 500);
  EXPECT_EQ(report.late, 0);
  EXPECT_NEAR(report.achieved_refresh_hz(), 85, 1e-4);
  EXPECT_EQ(report.shortest_interval_s, report.longest_interval_s);
}

TEST(FramePacer, LateWakingDoesNotAddUp) {
  SluggishClock clock(200'000);
  FramePacer pacer(clock, 100);
  for (int i = 0; i < 100; ++i) pacer.next_frame();
  EXPECT_EQ(clock.now_ns(), 1000 + 99 * 10'000'000 + 200'000);
  EXPECT_EQ(pacer.report().late, 0);
}

TEST(FramePacer, ALateFrameStartsAtOnceAndTheRateGoesOnFromIt) {
  SluggishClock clock(0);
  FramePacer pacer(clock, 100);
  pacer.next_frame();
  clock.work(25'000'000);  // two and a half intervals
  const PacedFrame late = pacer.next_frame();
  EXPECT_TRUE(late.late);
  EXPECT_EQ(late.started_ns, 1000 + 25'000'000);
  EXPECT_EQ(late.due_ns, 1000 + 10'000'000);
  EXPECT_DOUBLE_EQ(late.interval.value(), 0.025);
  const PacedFrame next = pacer.next_frame();  // no hurrying after the lost frames
  EXPECT_EQ(next.started_ns, late.started_ns + 10'000'000);
  const PacingReport report = pacer.report();
  EXPECT_EQ(report.late, 1);
  EXPECT_DOUBLE_EQ(report.longest_interval_s, 0.025);
  EXPECT_DOUBLE_EQ(report.shortest_interval_s, 0.010);
  EXPECT_DOUBLE_EQ(report.mean_interval_s, 0.0175);
}

TEST(FramePacer, ANewRateHoldsFromTheNextFrame) {
  SimulatedClock clock;
  FramePacer pacer(clock, 50);
  pacer.next_frame();
  pacer.next_frame();
  pacer.set_refresh_hz(100);
  EXPECT_EQ(pacer.next_frame().started_ns, 20'000'000 + 10'000'000);
}

TEST(FramePacer, ImpossibleRatesAreRefused) {
  SimulatedClock clock;
  for (const double bad : {0.0, -60.0, 0.5, 1e9, std::nan("")})
    EXPECT_THROW(FramePacer(clock, bad), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
