#include "hardware/hid/blink1_report.h"

namespace wheatstone {
namespace {

std::string report(char command) {
  std::string bytes(kBlink1Bytes, '\0');
  bytes[0] = static_cast<char>(kBlink1Report);
  bytes[1] = command;
  return bytes;
}

/// Some models leave out the last byte, some the number.
bool answers(std::string_view bytes, char command) {
  return (bytes.size() == kBlink1Bytes || bytes.size() == kBlink1Bytes - 1) &&
         (bytes[0] == 0 || bytes[0] == static_cast<char>(kBlink1Report)) && bytes[1] == command;
}

}  // namespace

std::string blink1_order(const Blink1Colour& colour) {
  std::string bytes = report('n');
  for (std::size_t i = 0; i < colour.size(); ++i) bytes[2 + i] = static_cast<char>(colour[i]);
  return bytes;
}

std::string blink1_colour_question(int led) {
  std::string bytes = report('r');
  bytes[7] = static_cast<char>(led);
  return bytes;
}

std::string blink1_version_question() {
  return report('v');
}

std::optional<Blink1Colour> parse_blink1_colour(std::string_view bytes) {
  if (!answers(bytes, 'r')) return std::nullopt;
  return Blink1Colour{static_cast<std::uint8_t>(bytes[2]), static_cast<std::uint8_t>(bytes[3]),
                      static_cast<std::uint8_t>(bytes[4])};
}

std::optional<std::string> parse_blink1_version(std::string_view bytes) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  if (!answers(bytes, 'v') || !digit(bytes[3]) || !digit(bytes[4])) return std::nullopt;
  return std::string{bytes[3], '.', bytes[4]};
}

}  // namespace wheatstone
