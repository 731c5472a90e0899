// A million damaged datagrams for the emulated controller, which takes them from the network.

#include <gtest/gtest.h>

#include "core/random.h"
#include "hardware/network/e131_packet.h"
#include "sim/wire/e131_receiver.h"
#include "tests/hardware/mutation.h"

namespace wheatstone {
namespace {

constexpr int kExecutions = 1'000'000;

TEST(E131Fuzz, DatagramsAreTakenOrRefused) {
  const E131Source source{{1, 2, 3}, "fuzz", 100};
  const std::vector<std::uint8_t> slots(24, 9), data = e131_data(source, 1, 2, slots),
                                                sync = e131_sync(source, 2);
  const std::string valid[] = {{data.begin(), data.end()}, {sync.begin(), sync.end()}};
  RandomStream random(7, 0);
  int taken = 0;
  for (int i = 0; i < kExecutions; ++i) {
    const std::string bytes = mutated(valid[i % 2], random);
    const auto m = parse_e131({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    if (!m) continue;
    ++taken;
    ASSERT_LE(m->slots.size(), bytes.size());
  }
  EXPECT_GT(taken, 1000);
}

TEST(E131Fuzz, StreamsOfAnythingLeaveTheControllerWorking) {
  World world("card", 0.02, 7);
  LedCeiling ceiling(world, {0, 100, 169, 170, 339, 5000});
  E131Node node(ceiling, 1, 2);
  RandomStream random(7, 1);
  const E131Source source{{1, 2, 3}, "fuzz", 100};
  Nanoseconds now = 0;
  for (int i = 0; i < kExecutions / 10; ++i) {
    const std::vector<std::uint8_t> slots(random.next() % 513, 255);
    std::vector<std::uint8_t> bytes = random.next() % 4 == 0
                                          ? e131_sync(source, 3)
                                          : e131_data(source, static_cast<int>(random.next() % 4),
                                                      random.next() % 2 ? 3 : 0, slots);
    bytes[kE131SyncSequenceAt] = static_cast<std::uint8_t>(random.next());
    if (bytes.size() > kE131OptionsAt) {
      bytes[kE131DataSequenceAt] = static_cast<std::uint8_t>(random.next());
      bytes[kE131OptionsAt] = random.next() % 16 == 0 ? kE131Terminated : 0;
    }
    node.receive(bytes, now += 1'000'000);
    ASSERT_GE(world.light.led_drive, 0);
    ASSERT_LE(world.light.led_drive, 1);
  }
  EXPECT_GT(node.shown(), 1000);
  EXPECT_GT(node.behind(), 1000);
  node.run(now + E131Node::kLossNs + 1);
  EXPECT_EQ(world.light.led_drive, 0);
}

}  // namespace
}  // namespace wheatstone
