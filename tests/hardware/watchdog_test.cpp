#include "hardware/watchdog.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>

#include "core/error.h"
#include "tests/contract/resources.h"

namespace wheatstone {
namespace {

TEST(Watchdog, BarksOnceWhenNobodyPetsIt) {
  const ResourceWatch resources;
  std::latch barked(1);
  std::atomic<int> barks = 0;
  const SteadyClock clock;
  const Nanoseconds start = clock.now_ns();
  {
    const Watchdog dog(Duration::of(0.05), [&] {
      ++barks;
      barked.count_down();
    });
    barked.wait();
    EXPECT_TRUE(dog.has_barked());
  }
  EXPECT_GE(clock.now_ns() - start, 50'000'000);
  EXPECT_EQ(barks, 1);
}

TEST(Watchdog, SleepsWhileItIsPetted) {
  std::atomic<int> barks = 0;
  {
    Watchdog dog(Duration::of(10), [&] { ++barks; });
    for (int i = 0; i < 1000; ++i) dog.pet();
    EXPECT_FALSE(dog.has_barked());
  }
  EXPECT_EQ(barks, 0) << "nor when it goes";
  EXPECT_THROW(Watchdog(Duration::of(0), [] {}), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
