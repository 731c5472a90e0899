// The emulated HID devices by themselves, against reference calibration_leds.md.

#include <gtest/gtest.h>

#include <cerrno>
#include <string>

#include "core/random.h"
#include "sim/wire/hid/blink1_firmware.h"
#include "sim/wire/hid/relay_firmware.h"
#include "tests/hardware/mutation.h"

namespace wheatstone {
namespace {

class HidFirmwareTest : public ::testing::Test {
 protected:
  static std::string report(std::initializer_list<int> bytes, std::size_t size) {
    std::string out;
    for (const int b : bytes) out += static_cast<char>(b);
    out.resize(size, '\0');
    return out;
  }
  int order(HidFirmware& relay, std::initializer_list<int> bytes) {
    return relay.set_report(0, report(bytes, 8), 0);
  }
  static std::string asked(HidFirmware& firmware, Nanoseconds now = 0) {
    std::string answer;
    EXPECT_EQ(firmware.get_report(1, answer, now), 0);
    return answer;
  }

  World world_{"card", 0.02, 7};
};

TEST_F(HidFirmwareTest, ARelayBoardAnswersAsInTheManual) {
  RelayFirmware relay(world_);
  order(relay, {0xff, 2});
  EXPECT_EQ(asked(relay), report({0x42, 0x49, 0x54, 0x46, 0x54, 0, 0, 2}, 8));
  EXPECT_EQ(world_.light.marker_mask, 2U);
  order(relay, {0xfe});
  EXPECT_EQ(world_.light.marker_mask, 15U);
  order(relay, {0xfd, 4});
  EXPECT_EQ(world_.light.marker_mask, 7U);
  order(relay, {0xfc});
  EXPECT_EQ(world_.light.marker_mask, 0U);
  order(relay, {0xfa, 'N', 'E', 'W', '0', '1'});
  EXPECT_EQ(asked(relay).substr(0, 5), "NEW01");
}

TEST_F(HidFirmwareTest, ARelayBoardIgnoresChannelsThatItLacksWithoutAnError) {
  RelayFirmware relay(world_);
  for (const int channel : {0, 5, 8, 255}) EXPECT_EQ(order(relay, {0xff, channel}), 0);
  EXPECT_EQ(world_.light.marker_mask, 0U);
}

TEST_F(HidFirmwareTest, RelaysOpenWhenTheirCableIsPulled) {
  RelayFirmware relay(world_);
  order(relay, {0xfe});
  relay.lose_power();
  EXPECT_EQ(world_.light.marker_mask, 0U);
}

TEST_F(HidFirmwareTest, Blink1FadesInUnitsOfTenMilliseconds) {
  Blink1Firmware blink1(world_);
  // To red within 2.56 + 0.04 s.
  EXPECT_EQ(blink1.set_report(1, report({1, 'c', 200, 0, 0, 1, 4, 0}, 9), 0), 0);
  EXPECT_EQ(world_.light.marker_mask, 1U);
  const auto red = [&](Nanoseconds now) {
    EXPECT_EQ(blink1.set_report(1, report({1, 'r', 0, 0, 0, 0, 0, 1}, 9), now), 0);
    return static_cast<unsigned char>(asked(blink1, now)[2]);
  };
  EXPECT_EQ(red(0), 0);
  EXPECT_EQ(red(1'300'000'000), 100);
  EXPECT_EQ(red(2'600'000'000), 200);
  EXPECT_EQ(red(9'000'000'000), 200);
}

TEST_F(HidFirmwareTest, Blink1SetsEitherLedOrBoth) {
  Blink1Firmware blink1(world_);
  const auto green = [&](int led) {
    blink1.set_report(1, report({1, 'r', 0, 0, 0, 0, 0, led}, 9), 0);
    return static_cast<unsigned char>(asked(blink1)[3]);
  };
  blink1.set_report(1, report({1, 'n', 0, 9, 0, 0, 0, 2}, 9), 0);
  EXPECT_EQ(green(1), 0);
  EXPECT_EQ(green(2), 9);
  blink1.set_report(1, report({1, 'n', 0, 7, 0, 0, 0, 0}, 9), 0);
  EXPECT_EQ(green(1), 7);
  EXPECT_EQ(green(2), 7);
  blink1.set_report(1, report({1, 'v'}, 9), 0);
  EXPECT_EQ(asked(blink1).substr(3, 2), "24");
}

TEST_F(HidFirmwareTest, Blink1StallsReportsThatItDoesNotHave) {
  Blink1Firmware blink1(world_);
  std::string answer;
  EXPECT_EQ(blink1.set_report(3, report({3, 'n'}, 9), 0), EPIPE);
  EXPECT_EQ(blink1.get_report(0, answer, 0), EPIPE);
}

TEST_F(HidFirmwareTest, NothingThatIsSentBreaksThem) {
  RelayFirmware relay(world_);
  Blink1Firmware blink1(world_);
  RandomStream random(7, 0);
  for (int i = 0; i < 200'000; ++i) {
    relay.set_report(static_cast<std::uint8_t>(random.next() % 3),
                     mutated(report({0xff, 2}, 8), random), i);
    EXPECT_LE(world_.light.marker_mask, 15U);
    blink1.set_report(static_cast<std::uint8_t>(random.next() % 3),
                      mutated(report({1, 'c', 1, 2, 3, 0, 5, 0}, 9), random), i);
    EXPECT_EQ(asked(blink1, i).size(), 9U);
  }
  EXPECT_EQ(asked(relay).size(), 8U);
}

}  // namespace
}  // namespace wheatstone
