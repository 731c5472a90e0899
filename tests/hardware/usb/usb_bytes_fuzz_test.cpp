// A million of each: descriptors that a device sends, requests and packets that a host sends to the
// emulated Fadecandy.

#include <gtest/gtest.h>

#include <algorithm>

#include "core/random.h"
#include "hardware/usb/usb_device.h"
#include "sim/wire/usb/fadecandy_firmware.h"
#include "tests/hardware/mutation.h"

namespace wheatstone {
namespace {

constexpr int kExecutions = 1'000'000;

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

TEST(UsbBytesFuzz, StringDescriptorsBecomePrintableText) {
  UsbDescription d;
  d.serial = "SIMFADECANDY0001";
  const std::vector<std::uint8_t> valid = d.string_descriptor(3);
  EXPECT_EQ(usb_text(valid), d.serial);
  RandomStream random(7, 0);
  for (int i = 0; i < kExecutions; ++i) {
    const std::string text = usb_text(bytes_of(mutated({valid.begin(), valid.end()}, random)));
    ASSERT_LE(text.size(), 127U);
    ASSERT_TRUE(std::all_of(text.begin(), text.end(),
                            [](unsigned char c) { return c >= 0x20 && c < 0x7f; }));
  }
}

TEST(UsbBytesFuzz, RequestsAreAnsweredWithinTheirLengthOrStalled) {
  World world("card", 0.02, 7);
  LedCeiling ceiling(world, {0, 511});
  FadecandyFirmware firmware(ceiling);
  RandomStream random(7, 1);
  int answered = 0;
  for (int i = 0; i < kExecutions; ++i) {
    UsbSetup s;
    s.request_type = static_cast<std::uint8_t>(random.next() % 3 ? 0x80 : random.next());
    s.request = static_cast<std::uint8_t>(random.next() % 12);
    s.value = static_cast<std::uint16_t>((random.next() % 8) << 8 | random.next() % 6);
    s.index = static_cast<std::uint16_t>(random.next() % 3);
    s.length = static_cast<std::uint16_t>(random.next() % 64);
    const UsbReply reply = firmware.control(s, {}, 0);
    if (reply.end != UsbReply::End::kDone) continue;
    ++answered;
    ASSERT_LE(reply.bytes.size(), std::max<std::size_t>(s.length, 4));
  }
  EXPECT_GT(answered, 1000);
}

TEST(UsbBytesFuzz, PacketsLeaveTheLedsWithinTheirRange) {
  World world("card", 0.02, 7);
  LedCeiling ceiling(world, {0, 63, 511});
  FadecandyFirmware firmware(ceiling);
  RandomStream random(7, 2);
  const std::string black(64, '\0');
  for (int i = 0; i < kExecutions; ++i) {
    std::string packet = mutated(black, random);
    if (!packet.empty()) packet[0] = static_cast<char>(random.next());
    ASSERT_EQ(firmware.receive(1, bytes_of(packet), 0).end, UsbReply::End::kDone);
    ASSERT_GE(world.light.led_drive, 0);
    ASSERT_LE(world.light.led_drive, 1);
  }
  EXPECT_GT(firmware.frames(), 1000U);
}

}  // namespace
}  // namespace wheatstone
