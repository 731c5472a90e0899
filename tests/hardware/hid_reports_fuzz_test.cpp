// A million damaged reports for each parser of what relay boards and blink(1) say.

#include <gtest/gtest.h>

#include <cctype>

#include "core/random.h"
#include "hardware/hid/blink1_report.h"
#include "hardware/hid/relay_report.h"
#include "tests/hardware/mutation.h"

namespace wheatstone {
namespace {

constexpr int kExecutions = 1'000'000;

TEST(HidReportsFuzz, RelayReports) {
  const std::string valid("BITFT\0\0\2", 8);
  RandomStream random(7, 0);
  int taken = 0;
  for (int i = 0; i < kExecutions; ++i) {
    const std::string bytes = mutated(i % 2 ? valid : '\1' + valid, random);
    const auto report = parse_relay_report(bytes);
    if (!report) continue;
    ++taken;
    ASSERT_EQ(report->board.size(), kRelayNameLength);
    for (const char c : report->board) ASSERT_TRUE(std::isprint(static_cast<unsigned char>(c)));
    ASSERT_NE(bytes.find(report->board), std::string::npos) << "nothing beyond what was sent";
  }
  EXPECT_GT(taken, 100'000);
  EXPECT_LT(taken, 900'000);
}

TEST(HidReportsFuzz, Products) {
  RandomStream random(7, 1);
  int taken = 0;
  for (int i = 0; i < kExecutions; ++i) {
    const std::string product = mutated("USBRelay4", random);
    const int channels = relay_channels(product);
    ASSERT_GE(channels, 0);
    ASSERT_LE(channels, 8);
    if (channels == 0) continue;
    ++taken;
    ASSERT_EQ(product, "USBRelay" + std::to_string(channels));
  }
  EXPECT_GT(taken, 100'000);
}

TEST(HidReportsFuzz, Blink1Answers) {
  const std::string colour("\1r\xff\x78\0\0\0\1\0", 9), version(
                                                            "\1v\0"
                                                            "24\0\0\0\0",
                                                            9);
  RandomStream random(7, 2);
  int colours = 0, versions = 0;
  for (int i = 0; i < kExecutions; ++i) {
    const std::string bytes = mutated(i % 2 ? colour : version, random);
    const auto shown = parse_blink1_colour(bytes);
    const auto firmware = parse_blink1_version(bytes);
    ASSERT_FALSE(shown && firmware) << "an answer to both questions";
    if (shown) {
      ++colours;
      ASSERT_EQ((*shown)[1], static_cast<std::uint8_t>(bytes[3]));
    }
    if (firmware) {
      ++versions;
      ASSERT_EQ(*firmware, (std::string{bytes[3], '.', bytes[4]}));
    }
  }
  EXPECT_GT(colours, 50'000);
  EXPECT_GT(versions, 50'000);
}

}  // namespace
}  // namespace wheatstone
