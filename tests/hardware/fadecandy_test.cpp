// Fadecandy: the bytes of its packets, and what the driver takes for settings.

#include "hardware/usb/fadecandy.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <set>

#include "core/files.h"
#include "hardware/usb/fadecandy_driver.h"
#include "tests/error_text.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

TEST(FadecandyPackets, OfABlackFrameAreZeroButForTheirHeads) {
  const Bytes b = fadecandy_frame({});
  ASSERT_EQ(b.size(), 1600U);
  for (std::size_t i = 0; i < b.size(); ++i) {
    const std::size_t packet = i / 64;
    const std::size_t expected = i % 64 ? 0 : packet < 24 ? packet : 0x38;
    EXPECT_EQ(b[i], expected) << i;
  }
}

TEST(FadecandyPackets, HoldTwentyOnePixelsEach) {
  FadecandyPixels pixels{};
  for (std::size_t p = 0; p < pixels.size(); ++p)
    pixels[p] = {static_cast<std::uint8_t>(p), static_cast<std::uint8_t>(p >> 8), 0x77};
  const Bytes b = fadecandy_frame(pixels);
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    const std::size_t at = p / 21 * 64 + 1 + 3 * (p % 21);
    EXPECT_EQ(b[at] | b[at + 1] << 8, static_cast<int>(p));
    EXPECT_EQ(b[at + 2], 0x77);
  }
}

TEST(FadecandyPackets, OfATableHoldThirtyOneEntriesEach) {
  FadecandyLut lut{};
  for (std::size_t i = 0; i < 3 * 257; ++i)
    lut[i / 257][i % 257] = static_cast<std::uint16_t>(i + 1);
  const Bytes b = fadecandy_lut(lut);
  ASSERT_EQ(b.size(), 1600U);
  EXPECT_EQ(b[0], 0x40);
  EXPECT_EQ(b[24 * 64], 0x78);
  for (std::size_t i = 0; i < 3 * 257; ++i) {
    const std::size_t at = i / 31 * 64 + 2 + 2 * (i % 31);
    EXPECT_EQ(b[at] | b[at + 1] << 8, static_cast<int>(i + 1));
  }
  for (std::size_t packet = 0; packet < 25; ++packet) EXPECT_EQ(b[packet * 64 + 1], 0);
}

TEST(FadecandyPackets, ConfigureDitheringAndFading) {
  for (const bool dither : {false, true})
    for (const bool fade : {false, true}) {
      Bytes expected(64);
      expected[0] = 0x80;
      expected[1] = static_cast<std::uint8_t>((dither ? 0 : 1) | (fade ? 0 : 2));
      EXPECT_EQ(fadecandy_config(dither, fade), expected);
    }
}

TEST(FadecandyTable, UndoesTheResponseOfTheLeds) {
  const FadecandyLut lut = fadecandy_response(2, {1, 1.5, 0.8});
  for (std::size_t c = 0; c < 3; ++c) {
    const double gamma = std::array{1.0, 1.5, 0.8}[c];
    EXPECT_EQ(lut[c][0], 0);
    EXPECT_EQ(lut[c][256], 65535);
    for (std::size_t i = 1; i < 257; ++i) {
      EXPECT_GE(lut[c][i], lut[c][i - 1]);
      const double code = std::min(1.0, static_cast<double>(i) / 256 * 65536 / 65535);
      EXPECT_NEAR(std::pow(lut[c][i] / 65535.0, gamma), code * code, 2e-4);
    }
  }
}

TEST(FadecandySettings, GiveEveryLedAPixelOfItsOwn) {
  FadecandySettings s;
  for (const auto& [per_strand, offset] : {std::pair{64, 0}, {32, 0}, {32, 32}, {40, 24}}) {
    s.leds_per_strand = per_strand;
    s.strand_offset = offset;
    std::set<int> pixels;
    for (const int p : fadecandy_pixels(s)) {
      EXPECT_GE(p % 64, offset);
      EXPECT_LT(p % 64, offset + per_strand);
      EXPECT_LT(p, 512);
      pixels.insert(p);
    }
    EXPECT_EQ(pixels.size(), 256U);
  }
}

TEST(FadecandySettings, AreRefusedWhereTheyCannotBe) {
  const auto refusal = [](const std::function<void(FadecandySettings&)>& change) {
    FadecandySettings s;
    change(s);
    return error_of([&] { Fadecandy{s}; });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal([](auto& s) { s.leds_per_strand = 31; }), HasSubstr("8 strands"));
  EXPECT_THAT(refusal([](auto& s) { s.leds_per_strand = 0; }), HasSubstr("do not fit a strand"));
  EXPECT_THAT(refusal([](auto& s) { s.strand_offset = 1; }), HasSubstr("do not fit a strand"));
  EXPECT_THAT(refusal([](auto& s) { s.strand_offset = -1; }), HasSubstr("do not fit a strand"));
  EXPECT_THAT(refusal([&](auto& s) { s.code_gamma = nan; }), HasSubstr("code gamma"));
  EXPECT_THAT(refusal([](auto& s) { s.response_gamma[2] = 0; }), HasSubstr("response gamma"));
  EXPECT_THAT(refusal([](auto& s) { s.max_mean_drive = 1.5; }), HasSubstr("no limit"));
  EXPECT_THAT(refusal([](auto& s) { s.mapping.corner = "top"; }), HasSubstr("no corner"));
}

TEST(FadecandyDriver, IsReadFromTheRigFile) {
  const TemporaryFolder folder;
  const auto file = folder.path / "leds.toml";
  DriverCatalogue catalogue;
  add_fadecandy_driver(catalogue);
  const auto read = [&](const std::string& keys) {
    write_text_atomically(file, "driver = \"fadecandy\"\n" + keys);
    return catalogue.read<LedArray>(TomlTable::read(file, "docs/rig_file.md"));
  };
  EXPECT_EQ(read("").address, "usb fadecandy");
  EXPECT_EQ(read("usb_serial = \"ABC\"\nleds_per_strand = 32\nstrand_offset = 8\ndither = false\n"
                 "interpolate = false\ncode_gamma = 2.2\nmax_mean_drive = 0.5\n"
                 "response_gamma = [1, 1, 1.1]\n")
                .address,
            "usb ABC");
  EXPECT_THAT(error_of([&] { read("leds_per_strand = 65\n"); }), HasSubstr("leds_per_strand"));
  EXPECT_THAT(error_of([&] { read("leds_per_strand = 16\n"); }), HasSubstr("8 strands"));
  EXPECT_THAT(error_of([&] { read("max_mean_drive = 0\n"); }), HasSubstr("max_mean_drive"));
  EXPECT_THAT(error_of([&] { read("rows = 0\n"); }), HasSubstr("rows"));
  EXPECT_THAT(error_of([&] { read("ditter = true\n"); }), HasSubstr("dither"));
}

}  // namespace
}  // namespace wheatstone
