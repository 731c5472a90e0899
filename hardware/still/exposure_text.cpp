#include "hardware/still/exposure_text.h"

#include <charconv>

namespace wheatstone {
namespace {

constexpr double kLongestS = 1e5;

/// The number in front, which is taken off.
std::optional<double> take_number(std::string_view& text) {
  double value = 0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

}  // namespace

std::optional<double> exposure_seconds(std::string_view text) {
  auto value = take_number(text);
  if (value && text.starts_with('/')) {
    text.remove_prefix(1);
    const auto divisor = take_number(text);
    value = divisor ? std::optional(*value / *divisor) : std::nullopt;
  }
  if (text == "s" || text == "\"") text = {};
  // Not a number fails both comparisons.
  if (!value || !text.empty() || !(*value > 0 && *value < kLongestS)) return std::nullopt;
  return value;
}

}  // namespace wheatstone
