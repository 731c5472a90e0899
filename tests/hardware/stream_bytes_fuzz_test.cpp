// A million damaged messages for each parser of what head trackers and photodiodes send: every one
// is taken, or refused with a DeviceError.

#include <gtest/gtest.h>

#include "core/random.h"
#include "hardware/head_stream.h"
#include "hardware/serial/photodiode_message.h"
#include "tests/hardware/mutation.h"

namespace wheatstone {
namespace {

constexpr int kExecutions = 1'000'000;

TEST(StreamBytesFuzz, HeadSamples) {
  HeadSample sample{"T-1", 17, 1'000'000, 1'012'000, {}};
  sample.eyes[0] = EyeCentre{{153.1, 130.2, 850}, Eigen::Matrix3d::Identity(), 0.9};
  const std::string valid = to_line(sample);
  RandomStream random(7, 0);
  int taken = 0;
  for (int i = 0; i < kExecutions; ++i) {
    try {
      const HeadSample s = parse_head_sample("the tracker", mutated(valid, random));
      ++taken;
      for (const auto& e : s.eyes)
        ASSERT_TRUE(!e || (e->p_rsb_mm.allFinite() && e->covariance_mm2.allFinite()));
    } catch (const DeviceError& e) {
      ASSERT_EQ(e.kind(), DeviceError::Kind::kProtocol);
    }
  }
  EXPECT_GT(taken, 1000);
}

TEST(StreamBytesFuzz, PhotodiodeBlocks) {
  const std::string valid = encode({7, {1, 2, 3, 0xffff}}) + encode({8, {5, 6}});
  RandomStream random(7, 1);
  int taken = 0;
  for (int i = 0; i < kExecutions; ++i) {
    std::string bytes = mutated(valid, random);
    try {
      const auto blocks = take_blocks("the photodiode", bytes);
      ASSERT_LE(bytes.size(), 3 + 2 * PhotodiodeBlock::kMostSamples + 2) << "of a block not whole";
      taken += static_cast<int>(blocks.size());
    } catch (const DeviceError& e) {
      ASSERT_EQ(e.kind(), DeviceError::Kind::kProtocol);
    }
  }
  EXPECT_GT(taken, 1000);
}

TEST(StreamBytesFuzz, PhotodiodeAnswers) {
  RandomStream random(7, 2);
  int taken = 0;
  for (int i = 0; i < kExecutions; ++i) {
    try {
      const auto n = numbers_of("it", mutated("TIME 12 4294967295", random), "TIME", 2);
      ASSERT_EQ(n.size(), 2U);
      ++taken;
    } catch (const DeviceError&) {
    }
  }
  EXPECT_GT(taken, 1000);
}

}  // namespace
}  // namespace wheatstone
