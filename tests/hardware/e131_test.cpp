// E1.31: the bytes of its packets, and what the driver takes for settings.

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "core/files.h"
#include "hardware/network/e131_driver.h"
#include "hardware/network/e131_led_array.h"
#include "tests/error_text.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

Bytes part(const Bytes& bytes, std::size_t at, std::size_t count) {
  const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(at);
  return {begin, begin + static_cast<std::ptrdiff_t>(count)};
}

TEST(E131Packet, OfAFullUniverseIsAsTheStandardPrintsIt) {
  E131Source source;
  for (std::size_t i = 0; i < 16; ++i) source.id[i] = static_cast<std::uint8_t>(0xa0 + i);
  source.name = "Source_A";
  Bytes slots(512, 0x55);
  const Bytes b = e131_data(source, 0x0102, 0x1f1a, slots);
  ASSERT_EQ(b.size(), 638U);
  EXPECT_EQ(part(b, 0, 22), (Bytes{0x00, 0x10, 0x00, 0x00, 'A', 'S',  'C',  '-', 'E', '1', '.',
                                   '1',  '7',  0,    0,    0,   0x72, 0x6e, 0,   0,   0,   4}));
  EXPECT_EQ(b[22], 0xa0);
  EXPECT_EQ(b[37], 0xaf);
  EXPECT_EQ(part(b, 38, 6), (Bytes{0x72, 0x58, 0, 0, 0, 2}));
  EXPECT_EQ(part(b, 44, 9), (Bytes{'S', 'o', 'u', 'r', 'c', 'e', '_', 'A', 0}));
  EXPECT_EQ(part(b, 108, 7), (Bytes{100, 0x1f, 0x1a, 0, 0, 0x01, 0x02}));
  EXPECT_EQ(part(b, 115, 11), (Bytes{0x72, 0x0b, 0x02, 0xa1, 0, 0, 0, 1, 0x02, 0x01, 0}));
  EXPECT_EQ(part(b, 126, 512), slots);
}

TEST(E131Packet, OfSynchronisationHas49Bytes) {
  const Bytes b = e131_sync({}, 7962);
  ASSERT_EQ(b.size(), 49U);
  EXPECT_EQ(part(b, 16, 6), (Bytes{0x70, 0x21, 0, 0, 0, 8}));
  EXPECT_EQ(part(b, 38, 11), (Bytes{0x70, 0x0b, 0, 0, 0, 1, 0, 0x1f, 0x1a, 0, 0}));
}

TEST(E131Packet, NamesAreCutAndUniversesHaveTheirGroup) {
  E131Source source;
  source.name = std::string(100, 'x');
  const Bytes b = e131_data(source, 1, 0, {});
  EXPECT_EQ(b[44 + 62], 'x');
  EXPECT_EQ(b[44 + 63], 0);
  EXPECT_EQ(e131_multicast_address(1), "239.255.0.1");
  EXPECT_EQ(e131_multicast_address(63999), "239.255.249.255");
}

TEST(E131Settings, GiveEveryLedAUniverse) {
  E131Settings s;
  EXPECT_EQ(e131_universes(s).count, 2);
  EXPECT_EQ(e131_universes(s).sync, 3);
  s.leds_per_universe = 64;
  s.sync_universe = 7962;
  EXPECT_EQ(e131_universes(s).count, 4);
  EXPECT_EQ(e131_universes(s).sync, 7962);
  s.mapping.rows = 1;
  s.sync_universe = 0;
  EXPECT_EQ(e131_universes(s).count, 1);
  EXPECT_EQ(e131_universes(s).sync, 0) << "nothing to synchronise";
}

TEST(E131Settings, AreRefusedWhereTheyCannotBe) {
  const auto refusal = [](const std::function<void(E131Settings&)>& change) {
    E131Settings s;
    s.address = "127.0.0.1";
    change(s);
    return error_of([&] { E131LedArray{s}; });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal([](auto& s) { s.address = "led.example"; }), HasSubstr("no IPv4 address"));
  EXPECT_THAT(refusal([](auto& s) { s.port = 0; }), HasSubstr("no UDP port"));
  EXPECT_THAT(refusal([](auto& s) { s.first_universe = 0; }), HasSubstr("are not all in"));
  EXPECT_THAT(refusal([](auto& s) { s.first_universe = 63998; }), HasSubstr("are not all in"));
  EXPECT_THAT(refusal([](auto& s) { s.sync_universe = 2; }), HasSubstr("cannot synchronise"));
  EXPECT_THAT(refusal([](auto& s) { s.leds_per_universe = 171; }), HasSubstr("1 to 170"));
  EXPECT_THAT(refusal([](auto& s) { s.priority = 201; }), HasSubstr("no priority"));
  EXPECT_THAT(refusal([&](auto& s) { s.response_gamma[1] = nan; }), HasSubstr("gamma"));
  EXPECT_THAT(refusal([&](auto& s) { s.max_mean_drive = nan; }), HasSubstr("no limit"));
  EXPECT_THAT(refusal([](auto& s) { s.max_mean_drive = 0; }), HasSubstr("no limit"));
  EXPECT_THAT(refusal([](auto& s) { s.keep_alive = Duration::of(3); }), HasSubstr("alive"));
}

TEST(E131Driver, IsReadFromTheRigFile) {
  const TemporaryFolder folder;
  const auto file = folder.path / "leds.toml";
  DriverCatalogue catalogue;
  add_e131_driver(catalogue);
  const auto read = [&](const std::string& keys) {
    write_text_atomically(file, "driver = \"e131\"\n" + keys);
    return catalogue.read<LedArray>(TomlTable::read(file, "docs/rig_file.md"));
  };
  EXPECT_EQ(read("address = \"10.0.0.9\"\nfirst_universe = 5\ncorner = \"front-left\"\n"
                 "lines = \"columns\"\nserpentine = false\nresponse_gamma = [2.2, 2.2, 2.2]\n")
                .address,
            "udp 10.0.0.9:5568 universe 5");
  EXPECT_EQ(read("").address, "udp multicast:5568 universe 1");
  EXPECT_THAT(error_of([&] { read("first_universe = 63999\n"); }), HasSubstr("first_universe"));
  EXPECT_THAT(error_of([&] { read("corner = \"top\"\n"); }), HasSubstr("corner"));
  EXPECT_THAT(error_of([&] { read("lines = \"diagonals\"\n"); }), HasSubstr("lines"));
  EXPECT_THAT(error_of([&] { read("strand = 1\n"); }), HasSubstr("strand"));
}

}  // namespace
}  // namespace wheatstone
