// EDIDs, gamma tables and verify().

#include <gmock/gmock.h>

#include "core/error.h"
#include "hardware/display_outputs.h"
#include "hardware/edid.h"

namespace wheatstone {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const EdidIdentity kLcd = {"WST", 513, 0x04030201, "LCD PANEL", "A-1"};

TEST(Edid, OfTheStandardIsRead) {
  // Worked by hand: "WST" is 23, 19, 20 in five bits each, big end first; product and serial have
  // their low byte first; texts end with a line feed and are filled with blanks.
  std::vector<std::byte> e(kEdidBlock);
  const auto put = [&](std::size_t at, std::initializer_list<int> values) {
    for (const int v : values) e[at++] = static_cast<std::byte>(v);
  };
  put(0, {0, 255, 255, 255, 255, 255, 255, 0, 0x5e, 0x74, 0x01, 0x02, 1, 2, 3, 4});
  put(54, {0x01, 0x1d, 0x80});  // a timing
  put(72, {0, 0, 0, 0xff, 0, 'A', '-', '1', '\n', ' '});
  put(90, {0, 0, 0, 0xfc, 0, 'L', 'C', 'D', ' ', 'P', 'A', 'N', 'E', 'L', '\n'});
  int sum = 0;
  for (const std::byte b : e) sum += std::to_integer<int>(b);
  e[127] = static_cast<std::byte>(256 - sum % 256);
  EXPECT_EQ(parse_edid(e), kLcd);
}

TEST(Edid, RoundTrips) {
  for (const EdidIdentity& id :
       {kLcd, EdidIdentity{"AAA", 0, 0, "", ""},
        EdidIdentity{"ZZZ", 65535, 4294967295, "THIRTEEN CHAR", "1234567890123"}})
    EXPECT_EQ(parse_edid(compose_edid(id)), id);
  EXPECT_THROW(compose_edid({"wst", 1, 1, "", ""}), ArgumentError);
  EXPECT_THROW(compose_edid({"WST", 1, 1, "FOURTEEN CHARS", ""}), ArgumentError);
}

TEST(Edid, DamagedOnesAreNone) {
  auto e = compose_edid(kLcd);
  EXPECT_EQ(parse_edid(std::span(e).first(127)), std::nullopt);
  e[127] ^= std::byte{1};
  EXPECT_EQ(parse_edid(e), std::nullopt) << "checksum";
  e[127] ^= std::byte{1};
  e[0] = std::byte{1};
  e[127] ^= std::byte{1};
  EXPECT_EQ(parse_edid(e), std::nullopt) << "head";
}

TEST(Gamma, IdentityIsKnownAtEverySize) {
  for (const std::size_t size : {2U, 256U, 1024U}) {
    std::vector<std::uint16_t> table(size);
    for (std::size_t i = 0; i < size; ++i)
      table[i] = static_cast<std::uint16_t>(identity_gamma(i, size));
    EXPECT_TRUE(is_identity_gamma(table));
    table[size / 2] = static_cast<std::uint16_t>(table[size / 2] - 40);
    EXPECT_FALSE(is_identity_gamma(table));
  }
  EXPECT_FALSE(is_identity_gamma({}));
}

DisplayOutput output(const std::string& connector, const EdidIdentity& edid, int x_px) {
  DisplayOutput o;
  o.connector = connector;
  o.edid = edid;
  o.x_px = x_px;
  o.width_px = 2048;
  o.height_px = 1536;
  o.refresh_hz = 59.95;
  o.bits_per_channel = 8;
  o.gamma_size = 256;
  o.gamma_is_identity = true;
  return o;
}

WantedOutput wish(const std::string& role, const EdidIdentity& edid,
                  const std::string& connector = "") {
  return {role, edid, connector, 2048, 1536, 60, 8};
}

std::vector<std::string> checks(const std::vector<DisplayOutput>& outputs,
                                const std::vector<WantedOutput>& wanted) {
  std::vector<std::string> out;
  for (const OutputProblem& p : verify(outputs, wanted)) {
    EXPECT_FALSE(p.role.empty() || p.found.empty() || p.remedy.empty());
    out.push_back(p.check);
  }
  return out;
}

TEST(VerifyOutputs, AllAsWanted) {
  EdidIdentity other = kLcd;
  other.serial = 2;
  const std::vector<DisplayOutput> outputs = {output("DP-1", kLcd, 0), output("DP-2", other, 2048)};
  EXPECT_THAT(checks(outputs, {wish("a", other), wish("b", kLcd)}), IsEmpty());
  EdidIdentity serial_only;
  serial_only.serial = 2;
  EXPECT_THAT(checks(outputs, {wish("a", serial_only)}), IsEmpty()) << "what is open fits all";
  EXPECT_THAT(checks(outputs, {wish("a", {}, "DP-1")}), IsEmpty()) << "by connector alone";
}

TEST(VerifyOutputs, EachCheckHasItsName) {
  const auto with = [&](auto change) {
    DisplayOutput o = output("DP-1", kLcd, 0);
    change(o);
    return checks({o}, {wish("a", kLcd)});
  };
  EXPECT_THAT(with([](DisplayOutput& o) { o.width_px = 1024; }), ElementsAre("mode"));
  EXPECT_THAT(with([](DisplayOutput& o) { o.width_px = o.height_px = 0; }), ElementsAre("mode"));
  EXPECT_THAT(with([](DisplayOutput& o) { o.refresh_hz = 50; }), ElementsAre("refresh"));
  EXPECT_THAT(with([](DisplayOutput& o) { o.refresh_hz = 0; }), ElementsAre("refresh"));
  EXPECT_THAT(with([](DisplayOutput& o) { o.bits_per_channel = 6; }), ElementsAre("depth"));
  EXPECT_THAT(with([](DisplayOutput& o) { o.is_scaled = true; }), ElementsAre("scaling"));
  EXPECT_THAT(with([](DisplayOutput& o) { o.gamma_is_identity = false; }), ElementsAre("gamma"));
  for (const char* some : {"on", "auto", "dynamic 2x2"})
    EXPECT_THAT(with([&](DisplayOutput& o) { o.dithering = some; }), ElementsAre("dithering"));
  EXPECT_THAT(with([](DisplayOutput& o) { o.link_bits_per_channel = 6; }),
              ElementsAre("link depth"));
  for (const char* some : {"Automatic", "Limited 16:235"})
    EXPECT_THAT(with([&](DisplayOutput& o) { o.range = some; }), ElementsAre("range"));
  EXPECT_THAT(with([](DisplayOutput& o) { o.has_colour_matrix = true; }),
              ElementsAre("colour matrix"));
  EXPECT_THAT(with([](DisplayOutput& o) {
                o.dithering = "off";
                o.range = "Full";
                o.link_bits_per_channel = 10;
              }),
              IsEmpty());
  EXPECT_THAT(with([](DisplayOutput& o) { o.edid.serial = 9; }), ElementsAre("identity"));
  EXPECT_THAT(with([](DisplayOutput& o) { o.edid = {}; }), ElementsAre("identity"));
}

TEST(VerifyOutputs, WhatIsNotKnownIsSaid) {
  DisplayOutput o = output("DP-1", kLcd, 0);
  EXPECT_THAT(describe(o), HasSubstr("at DP-1, dithering unknown, bits unknown, range unknown"));
  o.dithering = "off";
  o.range = "Full";
  o.link_bits_per_channel = 10;
  EXPECT_THAT(describe(o), HasSubstr("dithering off, at most 10 bits, range Full"));
}

TEST(VerifyOutputs, NeverGuessesBetweenTwins) {
  const std::vector<DisplayOutput> twins = {output("DP-1", kLcd, 0), output("DP-2", kLcd, 2048)};
  EXPECT_THAT(checks(twins, {wish("a", kLcd), wish("b", kLcd)}),
              ElementsAre("identity", "identity"));
  EXPECT_THAT(verify(twins, {wish("a", kLcd)})[0].found, HasSubstr("DP-1, DP-2"));
  EXPECT_THAT(checks(twins, {wish("a", kLcd, "DP-2"), wish("b", kLcd, "DP-1")}), IsEmpty());
  EXPECT_EQ(find_output(twins, wish("a", kLcd)), nullptr);
  EXPECT_EQ(find_output(twins, wish("a", kLcd, "DP-2")), &twins[1]);
}

TEST(VerifyOutputs, SeesCablesThatWereSwapped) {
  EdidIdentity projector = kLcd;
  projector.name = "PROJECTOR";
  const auto problems =
      verify({output("DP-1", projector, 0), output("DP-2", kLcd, 2048)}, {wish("a", kLcd, "DP-1")});
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_EQ(problems[0].check, "connector");
  EXPECT_THAT(problems[0].found, HasSubstr("DP-2"));
  const auto gone = verify({output("DP-1", projector, 0)}, {wish("a", kLcd, "DP-1")});
  EXPECT_EQ(gone[0].check, "identity");
  EXPECT_THAT(gone[0].found, HasSubstr("PROJECTOR"));
}

TEST(VerifyOutputs, SeesDisplaysThatShareRolesOrPixels) {
  EXPECT_THAT(checks({output("DP-1", kLcd, 0)}, {wish("a", kLcd), wish("b", kLcd)}),
              ElementsAre("one role"));
  EdidIdentity other = kLcd;
  other.serial = 2;
  EXPECT_THAT(checks({output("DP-1", kLcd, 0), output("DP-2", other, 2047)},
                     {wish("a", kLcd), wish("b", other)}),
              ElementsAre("apart"));
}

}  // namespace
}  // namespace wheatstone
