#include "sim/wire/still/ptp_container.h"

#include <algorithm>

#include "sim/wire/still/little_endian.h"

namespace wheatstone {
namespace {

constexpr std::size_t kLongestData = 1U << 16;
constexpr std::size_t kLongestText = 254;

bool possible(std::size_t length, std::uint16_t type) {
  if (type == static_cast<std::uint16_t>(PtpType::kCommand))
    return length >= kPtpHeaderBytes && length <= kPtpHeaderBytes + 4 * kPtpParameters &&
           length % 4 == 0;
  return type == static_cast<std::uint16_t>(PtpType::kData) && length >= kPtpHeaderBytes &&
         length <= kPtpHeaderBytes + kLongestData;
}

}  // namespace

std::vector<std::byte> encode(const PtpContainer& c) {
  std::vector<std::byte> out;
  const std::size_t length = kPtpHeaderBytes + 4 * c.parameters.size() + c.data.size();
  out.reserve(length);
  append(out, static_cast<std::uint32_t>(length));
  append(out, static_cast<std::uint16_t>(c.type));
  append(out, c.code);
  append(out, c.transaction);
  for (const std::uint32_t p : c.parameters) append(out, p);
  out.insert(out.end(), c.data.begin(), c.data.end());
  return out;
}

PtpAssembler::State PtpAssembler::feed(std::span<const std::byte> transfer) {
  if (transfer.empty()) return State::kWaiting;  // ends a container that fills its packets
  if (bytes_.size() + transfer.size() > kPtpHeaderBytes + kLongestData) {
    bytes_.clear();
    return State::kMalformed;
  }
  bytes_.insert(bytes_.end(), transfer.begin(), transfer.end());
  if (bytes_.size() < kPtpHeaderBytes) return State::kWaiting;
  const auto length = number_at<std::uint32_t>(bytes_, 0);
  const auto type = number_at<std::uint16_t>(bytes_, 4);
  if (!possible(length, type) || bytes_.size() > length) {
    bytes_.clear();
    return State::kMalformed;
  }
  if (bytes_.size() < length) return State::kWaiting;
  container_ = {static_cast<PtpType>(type),
                number_at<std::uint16_t>(bytes_, 6),
                number_at<std::uint32_t>(bytes_, 8),
                {},
                {}};
  const auto rest = std::span(bytes_).subspan(kPtpHeaderBytes);
  if (container_.type == PtpType::kData)
    container_.data.assign(rest.begin(), rest.end());
  else
    for (std::size_t i = 0; i < rest.size(); i += 4)
      container_.parameters.push_back(number_at<std::uint32_t>(rest, i));
  bytes_.clear();
  return State::kWhole;
}

void append_ptp_text(std::vector<std::byte>& out, const std::string& text) {
  const std::string kept = text.substr(0, kLongestText);
  if (kept.empty()) {
    append(out, std::uint8_t{0});
    return;
  }
  append(out, static_cast<std::uint8_t>(kept.size() + 1));
  for (const char c : kept)
    append(out, static_cast<std::uint16_t>(static_cast<unsigned char>(c) < 0x80 ? c : '?'));
  append(out, std::uint16_t{0});
}

void append_ptp_codes(std::vector<std::byte>& out, const std::vector<std::uint16_t>& codes) {
  append(out, static_cast<std::uint32_t>(codes.size()));
  for (const std::uint16_t code : codes) append(out, code);
}

}  // namespace wheatstone
