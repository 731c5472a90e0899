#pragma once
// The reports of USB relay boards 16c0:05df (reference calibration_leds.md): no report numbers,
// eight bytes.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace wheatstone {

inline constexpr std::size_t kRelayNameLength = 5;

/// Orders, each with the number 0 in front as hidapi takes them. Channels count from 1.
std::string relay_order(int channel, bool on);
std::string relay_order_all(bool on);

struct RelayReport {
  std::string board;    // its name: five printable characters
  std::uint8_t on = 0;  // bit 0: channel 1
};
/// As Linux hands it over, or with the report's number in front as other systems do; nothing: it is
/// neither.
std::optional<RelayReport> parse_relay_report(std::string_view);

/// Of a product "USBRelay4"; 0: it is another one, or has none.
int relay_channels(std::string_view product);

}  // namespace wheatstone
