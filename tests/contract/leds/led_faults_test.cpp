// Every line of the tables of faults of E1.31 and of the simulated LEDs, carried out; and what
// E1.31 receivers see.

#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <set>

#include "tests/contract/fault_call.h"
#include "tests/contract/leds/led_backends.h"
#include "tests/contract/leds/led_faults.h"
#include "tests/contract/resources.h"
#include "tests/contract/warm_up.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

Deadline soon() {
  return SteadyClock().in(Duration::of(2));
}

class LedFaultTest : public ::testing::TestWithParam<FaultCase> {
 protected:
  static void SetUpTestSuite() { warm_up(led_world()); }
  ResourceWatch resources_;
};

class SimulatedLedFaults : public LedFaultTest {};

TEST_P(SimulatedLedFaults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  TwinLedBackend backend;
  const auto in_time = [&] { return backend.clock().in(Duration::of(1)); };
  backend.leds().set_all(0.5, in_time());
  arm(backend.world().faults, "leds", fault);
  expect_fault(fault, [&](const Deadline&) { backend.leds().set_all(0.2, in_time()); });
  EXPECT_NEAR(backend.light(), 0.5, 1e-6);
  if (std::string(fault.after) == "gone") {
    EXPECT_EQ(kind_of([&] { backend.leds().set_all(0.2, in_time()); }), Kind::kDisconnected);
    backend.world().faults.reconnect("leds");
  }
  backend.leds().set_all(0.2, in_time());
  EXPECT_NEAR(backend.light(), 0.2, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Leds, SimulatedLedFaults, ::testing::ValuesIn(kSimulatedLedFaults),
                         [](const auto& fault) { return test_name(fault.param); });

class E131Faults : public LedFaultTest {};

TEST_P(E131Faults, EndAsDocumented) {
  const FaultCase& fault = GetParam();
  const std::string what = fault.fault;
  E131Backend backend;
  if (std::string(fault.state) == "opening") {
    E131Settings settings = backend.settings();
    if (what == "nobody listens") backend.unplug();
    if (what == "another machine's address") settings.from = "192.0.2.1";
    if (what == "broadcast address") settings.address = "255.255.255.255";
    expect_fault(fault, [&](const Deadline&) { E131LedArray{settings}; });
    return;
  }
  LedArray& leds = backend.leds();
  leds.set_all(0.5, soon());
  ASSERT_TRUE(backend.shows(0.5));
  SteadyClock clock;
  if (what == "controller switched off") {
    backend.unplug();
    if (std::string(fault.state) == "idle")
      clock.wait_until(clock.in(3 * backend.settings().keep_alive).at_ns);
    else  // this one tells
      kind_of([&] { leds.set_all(0.2, soon()); });
  }
  expect_fault(fault, [&](const Deadline& d) {
    if (what == "more light than allowed")
      leds.set_all(0.8, d);
    else
      leds.set_all(0.2, what == "no time left" ? Deadline{clock.now_ns()} : d);
  });
  if (std::string(fault.after) == "gone") {
    EXPECT_EQ(kind_of([&] { leds.set_all(0.2, soon()); }), Kind::kDisconnected);
    return;
  }
  EXPECT_NEAR(backend.light(), 0.5, 0.01);
  leds.set_all(0.2, soon());
  EXPECT_TRUE(backend.shows(0.2));
  backend.close();
  EXPECT_TRUE(backend.shows(0));
}

INSTANTIATE_TEST_SUITE_P(Leds, E131Faults, ::testing::ValuesIn(kE131Faults),
                         [](const auto& fault) { return test_name(fault.param); });

class E131Stream : public LedFaultTest {};

TEST_F(E131Stream, EveryLedHangsWhereTheMappingSays) {
  E131Backend backend;
  for (const int led : {0, 15, 16, 100, 170, 255}) {
    LedFrame frame{cv::Mat3f::zeros(16, 16)};
    frame.drive(led / 16, led % 16) = {1, 0, 0.25F};
    backend.leds().set_frame(frame, soon());
    ASSERT_TRUE(backend.shows(1.25 / 768, 1e-4));
    int lit = 0;
    backend.receiver().with_node([&](E131Node&) {
      for (const auto& rgb : backend.ceiling().light()) lit += rgb[0] + rgb[1] + rgb[2] > 0;
      const auto& rgb = backend.ceiling().light()[static_cast<std::size_t>(led)];
      EXPECT_EQ(rgb[0], 1);
      EXPECT_EQ(rgb[1], 0);
      EXPECT_NEAR(rgb[2], 0.25, 0.005);
    });
    EXPECT_EQ(lit, 1) << led;
    backend.leds().all_off();
    ASSERT_TRUE(backend.shows(0, 1e-4));
  }
}

TEST_F(E131Stream, IsKeptAliveInOrderAndEndsWithTerminations) {
  E131Backend backend;
  std::set<std::uint8_t> sequences;
  int seen = 0;
  backend.receiver().filter([&](std::span<const std::uint8_t> bytes) {
    const auto m = parse_e131(bytes);
    if (m && m->kind == E131Message::Kind::kData && m->universe == 7) {
      sequences.insert(m->sequence);
      ++seen;
    }
    return true;
  });
  backend.leds().set_all(0.5, soon());
  SteadyClock clock;
  clock.wait_until(clock.in(Duration::of(0.55)).at_ns);
  backend.receiver().with_node([&](const E131Node& node) {
    EXPECT_GE(seen, 3 + 4) << "two at the start, the frame, and one each tenth of a second";
    EXPECT_EQ(node.streams(), 2);
    EXPECT_EQ(node.behind(), 0);
    EXPECT_EQ(node.refused(), 0);
    EXPECT_EQ(static_cast<int>(sequences.size()), seen);
  });
  backend.close();
  const Nanoseconds end = clock.in(Duration::of(1)).at_ns;
  for (int n = 0; n < 6 && clock.now_ns() < end; clock.wait_until(clock.now_ns() + 1'000'000))
    backend.receiver().with_node([&](const E131Node& node) { n = node.terminations(); });
  backend.receiver().with_node([](const E131Node& node) {
    EXPECT_EQ(node.terminations(), 6) << "three for each universe";
    EXPECT_EQ(node.streams(), 0);
  });
}

TEST_F(E131Stream, ALostUniverseShowsNoHalfFrame) {
  E131Backend backend;
  backend.leds().set_all(0.5, soon());
  ASSERT_TRUE(backend.shows(0.5));
  // The synchronisation is lost: nothing changes until the frame is repeated.
  bool lose = true;
  backend.receiver().filter([&](std::span<const std::uint8_t> bytes) {
    const auto m = parse_e131(bytes);
    const bool sync = m && m->kind == E131Message::Kind::kSync;
    return !(sync && std::exchange(lose, lose && !sync));
  });
  double least = 1, most = 0;
  backend.leds().set_all(0.1, soon());
  SteadyClock clock;
  for (const Nanoseconds end = clock.in(Duration::of(1)).at_ns;
       backend.light() > 0.11 && clock.now_ns() < end;) {
    least = std::min(least, backend.light());
    most = std::max(most, backend.light());
    clock.wait_until(clock.now_ns() + 1'000'000);
  }
  EXPECT_NEAR(most, 0.5, 0.01);
  EXPECT_TRUE(least > 0.49 || least < 0.11) << least;
  EXPECT_TRUE(backend.shows(0.1));
}

TEST_F(E131Stream, StartsAnewWhereAnotherObjectBrokeOff) {
  E131Backend backend;
  // As a program leaves it that was killed: no termination, some sequence numbers further.
  E131Settings settings = backend.settings();
  for (int sent = 0; sent < 45; sent += 5) {
    bool cut = false;
    backend.receiver().filter([&](std::span<const std::uint8_t> bytes) {
      const auto m = parse_e131(bytes);
      return !cut && !(m && m->terminated);
    });
    {
      E131LedArray killed(settings);
      for (int i = 0; i < sent; ++i) killed.set_all(0.3, soon());
      ASSERT_TRUE(backend.shows(sent ? 0.3 : 0));
      backend.receiver().with_node([&](E131Node&) { cut = true; });
    }
    backend.receiver().filter({});
    E131LedArray again(settings);
    again.set_all(0.6, soon());
    EXPECT_TRUE(backend.shows(0.6)) << "after " << sent << " frames";
  }
}

TEST_F(E131Stream, ALostStreamIsDark) {
  E131Backend backend;
  backend.leds().set_all(0.5, soon());
  ASSERT_TRUE(backend.shows(0.5));
  backend.receiver().with_node([&](E131Node& node) {
    node.run(SteadyClock().now_ns() + E131Node::kLossNs + 1);
    EXPECT_EQ(backend.light(), 0);
  });
}

}  // namespace
}  // namespace wheatstone
