// A million damaged messages for each parser of what spectroradiometers and displays send: every
// one is taken, or refused with a DeviceError.

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
#include "hardware/argyll/spotread_output.h"
#include "hardware/edid.h"
#include "hardware/serial/jeti_message.h"
#include "tests/hardware/mutation.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr int kExecutions = 1'000'000;

TEST(MeterBytesFuzz, JetiTokens) {
  const std::string valid =
      "JETI_SB1211\r\x06\x07laser: 0\r\x15\x05"
      "1.23E-05\r";
  RandomStream random(7, 0);
  int taken = 0;
  for (int i = 0; i < kExecutions; ++i) {
    std::string bytes = mutated(valid, random);
    try {
      while (const auto token = take_token("it", bytes)) {
        ++taken;
        ASSERT_LE(token->text.size(), 160U);
      }
      ASSERT_LE(bytes.size(), 160U);
    } catch (const DeviceError& e) {
      ASSERT_EQ(e.kind(), Kind::kProtocol);
      ASSERT_TRUE(bytes.empty());
    }
  }
  EXPECT_GT(taken, kExecutions);
}

TEST(MeterBytesFuzz, JetiNumbers) {
  RandomStream random(7, 1);
  int taken = 0;
  for (int i = 0; i < kExecutions; ++i) {
    try {
      ASSERT_TRUE(std::isfinite(
          jeti_number("it", mutated("Chrom_x: 0.3127 Chrom_y: 0.3290", random), "Chrom_y")));
      ++taken;
    } catch (const DeviceError& e) {
      ASSERT_EQ(e.kind(), Kind::kProtocol);
    }
    const auto value = jeti_value(mutated(" 1.23456E-05", random));
    ASSERT_TRUE(!value || std::isfinite(*value));
  }
  EXPECT_GT(taken, 1000);
}

TEST(MeterBytesFuzz, CgatsSpectra) {
  const std::string valid =
      "SPECT\nKEYWORD \"SPECTRAL_BANDS\"\nSPECTRAL_BANDS \"3\"\nSPECTRAL_START_NM \"380\"\n"
      "SPECTRAL_END_NM \"390\"\nSPECTRAL_NORM \"1.0\"\n# a comment\nNUMBER_OF_SETS 1\n"
      "BEGIN_DATA\n0.1 0.2 0.3\nEND_DATA\n";
  RandomStream random(7, 2);
  int taken = 0;
  for (int i = 0; i < kExecutions; ++i) {
    try {
      const SpectralRadiance s = parse_cgats_spectrum("it", mutated(valid, random));
      ++taken;
      ASSERT_GE(s.values.size(), 2U);
      ASSERT_GT(s.step_nm, 0);
      for (const double v : s.values) ASSERT_TRUE(std::isfinite(v));
    } catch (const DeviceError& e) {
      ASSERT_EQ(e.kind(), Kind::kProtocol);
    }
  }
  EXPECT_GT(taken, 1000);
}

TEST(MeterBytesFuzz, SpotreadResults) {
  RandomStream random(7, 3);
  int taken = 0;
  for (int i = 0; i < kExecutions; ++i) {
    const auto xyz = parse_spotread_xyz(
        mutated("\n Result is XYZ: 95.0 100.0 108.9, Yxy: 100.0 0.3127 0.3290\n", random));
    if (!xyz) continue;
    ++taken;
    ASSERT_TRUE(xyz->allFinite());
  }
  EXPECT_GT(taken, 1000);
}

TEST(MeterBytesFuzz, Edids) {
  const auto block = compose_edid({"WST", 7, 11, "NAME", "SERIAL"});
  const std::string valid(reinterpret_cast<const char*>(block.data()), block.size());
  RandomStream random(7, 4);
  int taken = 0;
  for (int i = 0; i < kExecutions; ++i) {
    std::string bytes = mutated(valid, random);
    if (bytes.size() >= kEdidBlock && i % 2 == 0) {  // past the checksum too
      unsigned sum = 0;
      for (std::size_t k = 0; k + 1 < kEdidBlock; ++k) sum += static_cast<unsigned char>(bytes[k]);
      bytes[kEdidBlock - 1] = static_cast<char>(256 - sum % 256);
    }
    const auto id = parse_edid(std::as_bytes(std::span(bytes)));
    if (!id) continue;
    ++taken;
    ASSERT_EQ(id->manufacturer.size(), 3U);
    ASSERT_LE(id->name.size(), 13U);
    for (const char c : id->name + id->serial_text) ASSERT_TRUE(c >= ' ' && c <= '~');
  }
  EXPECT_GT(taken, 1000);
}

}  // namespace
}  // namespace wheatstone
