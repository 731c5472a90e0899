#pragma once
// The reports of blink(1) (reference calibration_leds.md): number 1, eight bytes more.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace wheatstone {

/// Red, green, blue as the LEDs are driven, 0..255; proportional to light.
using Blink1Colour = std::array<std::uint8_t, 3>;

inline constexpr std::uint8_t kBlink1Report = 1;
inline constexpr std::size_t kBlink1Bytes = 9;  // with the number

/// Both LEDs at once, without fading.
std::string blink1_order(const Blink1Colour&);
/// Questions: the answer is the next report that the device is asked for.
std::string blink1_colour_question(int led);  // 1 or 2
std::string blink1_version_question();

/// Nothing: it is no answer to that question.
std::optional<Blink1Colour> parse_blink1_colour(std::string_view);
std::optional<std::string> parse_blink1_version(std::string_view);  // "2.4"

}  // namespace wheatstone
