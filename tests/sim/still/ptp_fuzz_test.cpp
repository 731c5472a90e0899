// A million messages that no sane host sends.

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/sim/still/ptp_host.h"

namespace wheatstone {
namespace {

std::vector<std::vector<std::byte>> valid_messages() {
  std::vector<std::vector<std::byte>> out;
  for (const std::uint16_t operation :
       {ptp::kGetDeviceInfo, ptp::kOpenSession, ptp::kGetStorageIds, ptp::kGetStorageInfo,
        ptp::kGetObjectHandles, ptp::kGetObjectInfo, ptp::kGetObject, ptp::kConnect,
        ptp::kExtendedInfo, ptp::kSetValue, ptp::kControl, ptp::kAllProperties})
    for (const std::uint32_t parameter :
         {0U, 1U, ptp::kShot, std::uint32_t{ptp::kSettableShutter}, std::uint32_t{ptp::kFullPress}})
      out.push_back(encode({PtpType::kCommand, operation, 1, {parameter}, {}}));
  std::vector<std::byte> time, down, up;
  append(time, 1U << 16 | 250);
  append(down, std::uint16_t{2});
  append(up, std::uint16_t{1});
  out.push_back(encode({PtpType::kData, ptp::kSetValue, 1, {}, time}));
  for (const auto& press : {down, up})
    for (int i = 0; i < 8; ++i)  // often, as it counts only behind its command
      out.push_back(encode({PtpType::kData, ptp::kControl, 1, {}, press}));
  return out;
}

TEST(PtpFuzz, NothingAHostSendsBreaksTheCamera) {
  constexpr int kMessages = 1'000'000;
  const auto valid = valid_messages();
  World world("card", 0.005, 7);
  PtpCameraOptions options;
  options.noise = false;
  PtpCameraFirmware camera(world, options);
  RandomStream random(3, 0);
  std::size_t halts = 0, answers = 0, pictures = 0;
  for (int i = 0; i < kMessages; ++i) {
    std::vector<std::byte> bytes = valid[random.next() % valid.size()];
    switch (random.next() % 4) {
      case 0:
        for (std::byte& b : bytes) b = static_cast<std::byte>(random.next());
        break;
      case 1:
        bytes[random.next() % bytes.size()] ^= static_cast<std::byte>(1U << random.next() % 8);
        break;
      case 2:
        bytes.resize(random.next() % (2 * bytes.size()));
        break;
      default:
        break;
    }
    const Nanoseconds now = Nanoseconds{1000} * i;
    camera.receive(bytes, now);
    halts += camera.halted();
    if (camera.halted()) camera.clear_halt();
    std::size_t taken = 0;
    while (const auto part = camera.bulk_in(4096, now)) {
      taken += part->size();
      ++answers;
      ASSERT_LT(taken, 1U << 20) << "message " << i;
    }
    pictures += camera.interrupt_in(now).has_value();
    ASSERT_LE(camera.pictures_waiting(), options.memory_pictures);
  }
  EXPECT_GT(halts, 1000U);
  EXPECT_GT(answers, 1000U);
  EXPECT_GT(pictures, 5U);
}

TEST(PtpFuzz, HalvesOfMessagesAreNotKeptForever) {
  PtpAssembler assembler;
  RandomStream random(4, 0);
  std::vector<std::byte> head;
  append(head, std::uint32_t{60'000});
  append(head, static_cast<std::uint16_t>(PtpType::kData));
  EXPECT_EQ(assembler.feed(head), PtpAssembler::State::kWaiting);
  std::size_t fed = 0;
  auto state = PtpAssembler::State::kWaiting;
  while (state == PtpAssembler::State::kWaiting && fed < 1U << 20) {
    const std::vector<std::byte> more(1 + random.next() % 4096);
    state = assembler.feed(more);
    fed += more.size();
  }
  EXPECT_LE(fed, 70'000U);
}

}  // namespace
}  // namespace wheatstone
