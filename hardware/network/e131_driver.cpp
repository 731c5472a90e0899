#include "hardware/network/e131_driver.h"

#include <fmt/format.h>

#include "hardware/network/e131_led_array.h"
#include "hardware/rig_file/led_keys.h"

namespace wheatstone {
namespace {

DevicePlan<LedArray> read_e131(const TomlTable& table) {
  E131Settings s;
  s.address = table.text_or("address", "");
  s.from = table.text_or("from", "");
  s.port = static_cast<int>(table.integer_or("udp_port", s.port, 1, 65535));
  s.first_universe =
      static_cast<int>(table.integer_or("first_universe", s.first_universe, 1, kE131LastUniverse));
  s.sync_universe = static_cast<int>(table.integer_or("sync_universe", 0, 0, kE131LastUniverse));
  s.priority = static_cast<int>(table.integer_or("priority", s.priority, 0, 200));
  s.mapping = read_led_mapping(table);
  s.leds_per_universe =
      static_cast<int>(table.integer_or("leds_per_universe", s.leds_per_universe, 1, 170));
  if (table.has("response_gamma"))
    s.response_gamma = table.numbers<3>("response_gamma", kLeastLedGamma, kMostLedGamma);
  s.max_mean_drive = table.number_or("max_mean_drive", s.max_mean_drive, 1e-3, 1);
  try {
    e131_universes(s);
  } catch (const ArgumentError& e) {
    table.fail("first_universe", e.what());
  }
  return {"",
          fmt::format("udp {}:{} universe {}", s.address.empty() ? "multicast" : s.address, s.port,
                      s.first_universe),
          "", [s](RigContext&) -> std::unique_ptr<LedArray> {
            return std::make_unique<E131LedArray>(s);
          }};
}

}  // namespace

void add_e131_driver(DriverCatalogue& catalogue) {
  catalogue.add<LedArray>("e131", read_e131);
}

}  // namespace wheatstone
