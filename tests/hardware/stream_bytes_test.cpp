#include <gmock/gmock.h>

#include "hardware/head_stream.h"
#include "hardware/serial/photodiode_message.h"
#include "tests/error_text.h"

namespace wheatstone {
namespace {

using ::testing::HasSubstr;

HeadSample sample() {
  HeadSample s{"T-1", 0xffffffff, 1'000'000, 1'012'000, {}};
  s.eyes[1] = EyeCentre{{153.1, 130.2, 850}, Eigen::Vector3d(0.01, 0.02, 0.3).asDiagonal(), 0.9};
  return s;
}

TEST(HeadSample, GoesOverTheLineUnchanged) {
  const HeadSample s = parse_head_sample("it", to_line(sample()));
  EXPECT_EQ(s.tracker, "T-1");
  EXPECT_EQ(s.number, 0xffffffffU);
  EXPECT_EQ(s.exposed_us, 1'000'000);
  EXPECT_EQ(s.sent_us, 1'012'000);
  EXPECT_FALSE(s.eyes[0]);
  ASSERT_TRUE(s.eyes[1]);
  EXPECT_EQ(s.eyes[1]->p_rsb_mm, sample().eyes[1]->p_rsb_mm);
  EXPECT_EQ(s.eyes[1]->covariance_mm2, sample().eyes[1]->covariance_mm2);
  EXPECT_EQ(s.eyes[1]->confidence, 0.9);
}

TEST(HeadSample, WhatCannotBeIsRefused) {
  const auto refusal = [](const auto& change) {
    HeadSample s = sample();
    change(s);
    return error_of([&] { parse_head_sample("it", to_line(s)); });
  };
  EXPECT_THAT(refusal([](HeadSample& s) { s.eyes[1]->confidence = 1.5; }), HasSubstr("confidence"));
  EXPECT_THAT(refusal([](HeadSample& s) { s.eyes[1]->p_rsb_mm.x() = -10'001; }),
              HasSubstr("farther"));
  EXPECT_THAT(refusal([](HeadSample& s) { s.eyes[1]->covariance_mm2(0, 0) = -1; }),
              HasSubstr("covariance"));
  EXPECT_THAT(refusal([](HeadSample& s) { s.eyes[1]->covariance_mm2(0, 1) = 0.1; }),
              HasSubstr("covariance"));
  EXPECT_THAT(refusal([](HeadSample& s) { s.sent_us = s.exposed_us - 1; }), HasSubstr("10 s"));
  EXPECT_THAT(refusal([](HeadSample& s) { s.tracker.assign(3000, 'x'); }), HasSubstr("too long"));
  EXPECT_THAT(error_of([] { parse_head_sample("it", std::string(2000, '[')); }),
              HasSubstr("5b 5b"));
}

TEST(TrackerClock, TheLeastDelayCountsAsNoneAndDriftIsFollowed) {
  TrackerClock clock;
  constexpr Nanoseconds kOffset = 5'000'000'000, kSecond = 1'000'000'000;
  const auto error_ns = [&](Nanoseconds t, Nanoseconds delay) {
    const HeadSample s{"", 0, t / 1000, t / 1000, {}};
    return clock.exposed_ns(s, t + kOffset + delay) - (t + kOffset);
  };
  EXPECT_EQ(error_ns(0, 30'000'000), 30'000'000) << "nothing better is known yet";
  EXPECT_EQ(error_ns(kSecond, 1'000'000), 1'000'000);
  // A late one does not move it but for what may be drift.
  EXPECT_NEAR(static_cast<double>(error_ns(2 * kSecond, 400'000'000)), 1'000'000, 300'000);
  // The offset grows by 100 ppm for 100 s.
  Nanoseconds error = 0;
  for (Nanoseconds i = 3; i < 100; ++i) error = error_ns(i * kSecond, 1'000'000 + 100'000 * i);
  EXPECT_EQ(error, 1'000'000 + 100'000 * 99);
}

TEST(PhotodiodeBlock, GoesOverTheLineUnchanged) {
  EXPECT_EQ(crc16("123456789"), 0x29b1) << "CRC-16/CCITT-FALSE";
  const std::string first = encode({255, {0, 0x1234, 0xffff}}), second = encode({0, {7}});
  EXPECT_EQ(first.substr(0, 7), std::string("\xa5\xff\x03\x00\x00\x34\x12", 7));
  std::string bytes = first + second.substr(0, 4);
  const auto blocks = take_blocks("it", bytes);
  ASSERT_EQ(blocks.size(), 1U);
  EXPECT_EQ(blocks[0].sequence, 255);
  EXPECT_EQ(blocks[0].samples, (std::vector<std::uint16_t>{0, 0x1234, 0xffff}));
  EXPECT_EQ(bytes, second.substr(0, 4)) << "what is not whole stays";
}

TEST(PhotodiodeBlock, EveryFlippedBitIsFound) {
  const std::string valid = encode({3, {100, 200, 300}});
  for (std::size_t bit = 0; bit < 8 * valid.size(); ++bit) {
    std::string bytes = valid;
    bytes[bit / 8] ^= static_cast<char>(1 << bit % 8);
    std::size_t blocks = 0;
    const std::string error = error_of([&] { blocks = take_blocks("it", bytes).size(); });
    EXPECT_EQ(blocks, 0U) << bit;
    // A longer block than it is may still be on its way.
    EXPECT_TRUE(error != "no error" || bit / 8 == 2) << bit;
  }
}

TEST(PhotodiodeAnswer, IsTheWordAndItsNumbers) {
  EXPECT_EQ(numbers_of("it", "TIME 1 4294967295", "TIME", 2),
            (std::vector<std::uint32_t>{1, 4294967295}));
  for (const char* bad : {"TIME 1", "TIME 1 2 3", "TIME 1 x", "TIME 1 4294967296", "TIM 1 2",
                          "TIME 1 2 ", "TIME1 2", "TIME -1 2", ""})
    EXPECT_THAT(error_of([&] { numbers_of("it", bad, "TIME", 2); }), HasSubstr("protocol")) << bad;
  EXPECT_THAT(error_of([] { numbers_of("it", "ERROR too \x1bhot", "TIME", 2); }),
              HasSubstr("says: too ?hot"));
}

}  // namespace
}  // namespace wheatstone
