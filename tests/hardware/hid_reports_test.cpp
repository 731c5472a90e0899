// Reports as reference calibration_leds.md gives them.

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>

#include "hardware/hid/blink1_report.h"
#include "hardware/hid/relay_report.h"

namespace wheatstone {
namespace {

std::string bytes(std::initializer_list<int> values) {
  std::string out;
  for (const int v : values) out += static_cast<char>(v);
  return out;
}

TEST(RelayReports, OrdersAreThoseOfTheManual) {
  EXPECT_EQ(relay_order(3, true), bytes({0, 0xff, 3, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(relay_order(8, false), bytes({0, 0xfd, 8, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(relay_order_all(true), bytes({0, 0xfe, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(relay_order_all(false), bytes({0, 0xfc, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(RelayReports, AnswersAreReadWithAndWithoutTheReportsNumber) {
  const std::string plain = bytes({0x42, 0x49, 0x54, 0x46, 0x54, 0, 0, 2});
  for (const std::string& answer : {plain, plain + '\0', '\1' + plain, '\0' + plain}) {
    const auto report = parse_relay_report(answer);
    ASSERT_TRUE(report);
    EXPECT_EQ(report->board, "BITFT");
    EXPECT_EQ(report->on, 2);
  }
}

TEST(RelayReports, OtherAnswersAreNone) {
  const std::string plain = bytes({0x42, 0x49, 0x54, 0x46, 0x54, 0, 0, 2});
  EXPECT_FALSE(parse_relay_report(""));
  EXPECT_FALSE(parse_relay_report(plain.substr(1)));
  EXPECT_FALSE(parse_relay_report(plain + "ab"));
  for (const char c : {'\0', '\x1b', '\x7f', '\xc3'}) {
    std::string other = plain;
    other[4] = c;
    EXPECT_FALSE(parse_relay_report(other));
  }
}

TEST(RelayReports, ProductsSayHowManyChannels) {
  EXPECT_EQ(relay_channels("USBRelay1"), 1);
  EXPECT_EQ(relay_channels("USBRelay8"), 8);
  for (const char* other :
       {"", "USBRelay", "USBRelay0", "USBRelay9", "USBRelay16", "HIDRelay4", "xUSBRelay4"})
    EXPECT_EQ(relay_channels(other), 0) << other;
}

TEST(Blink1Reports, OrdersAreThoseOfTheManual) {
  EXPECT_EQ(blink1_order({255, 120, 0}), bytes({1, 'n', 255, 120, 0, 0, 0, 0, 0}));
  EXPECT_EQ(blink1_colour_question(2), bytes({1, 'r', 0, 0, 0, 0, 0, 2, 0}));
  EXPECT_EQ(blink1_version_question(), bytes({1, 'v', 0, 0, 0, 0, 0, 0, 0}));
}

TEST(Blink1Reports, AnswersAreRead) {
  EXPECT_EQ(parse_blink1_colour(bytes({1, 'r', 255, 120, 0, 0, 0, 1, 0})),
            (Blink1Colour{255, 120, 0}));
  EXPECT_EQ(parse_blink1_version(bytes({1, 'v', 0, '2', '4', 0, 0, 0, 0})), "2.4");
  // As a first model was seen to send it.
  EXPECT_EQ(parse_blink1_version(bytes({0, 'v', 0, '2', '4', 0, 0, 0})), "2.4");
}

TEST(Blink1Reports, OtherAnswersAreNone) {
  EXPECT_FALSE(parse_blink1_colour(""));
  EXPECT_FALSE(parse_blink1_colour(bytes({1, 'r', 255, 120, 0, 0, 0})));
  EXPECT_FALSE(parse_blink1_colour(bytes({1, 'v', 0, '2', '4', 0, 0, 0, 0})));
  EXPECT_FALSE(parse_blink1_colour(bytes({2, 'r', 255, 120, 0, 0, 0, 0, 0})));
  EXPECT_FALSE(parse_blink1_version(bytes({1, 'v', 0, 'x', '4', 0, 0, 0, 0})));
  EXPECT_FALSE(parse_blink1_version(bytes({1, 'r', 0, '2', '4', 0, 0, 0, 0})));
}

}  // namespace
}  // namespace wheatstone
