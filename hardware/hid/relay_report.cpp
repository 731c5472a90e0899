#include "hardware/hid/relay_report.h"

#include <algorithm>

namespace wheatstone {
namespace {

constexpr std::size_t kReport = 8, kStateAt = 7;

std::string order(unsigned char code, int channel) {
  std::string report(1 + kReport, '\0');
  report[1] = static_cast<char>(code);
  report[2] = static_cast<char>(channel);
  return report;
}

bool is_name(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c < 0x7f; });
}

}  // namespace

std::string relay_order(int channel, bool on) {
  return order(on ? 0xff : 0xfd, channel);
}

std::string relay_order_all(bool on) {
  return order(on ? 0xfe : 0xfc, 0);
}

std::optional<RelayReport> parse_relay_report(std::string_view bytes) {
  if (bytes.size() == 1 + kReport && !is_name(bytes.substr(0, 1))) bytes.remove_prefix(1);
  if (bytes.size() < kReport || bytes.size() > 1 + kReport) return std::nullopt;
  const std::string_view name = bytes.substr(0, kRelayNameLength);
  if (!is_name(name)) return std::nullopt;
  return RelayReport{std::string(name), static_cast<std::uint8_t>(bytes[kStateAt])};
}

int relay_channels(std::string_view product) {
  constexpr std::string_view kProduct = "USBRelay";
  if (product.size() != kProduct.size() + 1 || !product.starts_with(kProduct)) return 0;
  const char last = product.back();
  return last >= '1' && last <= '8' ? last - '0' : 0;
}

}  // namespace wheatstone
