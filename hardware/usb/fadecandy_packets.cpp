#include "hardware/usb/fadecandy_packets.h"

#include <algorithm>
#include <cmath>

namespace wheatstone {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kPacket = 64;
constexpr std::uint8_t kLut = 0x40, kConfig = 0x80, kFinal = 0x20;
constexpr std::uint8_t kNoDither = 0x01, kNoInterpolation = 0x02;

/// Cuts `content` into packets of `each` bytes that begin at byte `at`.
Bytes packets(std::uint8_t type, const Bytes& content, std::size_t each, std::size_t at) {
  const std::size_t count = (content.size() + each - 1) / each;
  Bytes out(count * kPacket);
  for (std::size_t i = 0; i < count; ++i)
    out[i * kPacket] = static_cast<std::uint8_t>(type | (i + 1 == count ? kFinal : 0) | i);
  for (std::size_t i = 0; i < content.size(); ++i)
    out[i / each * kPacket + at + i % each] = content[i];
  return out;
}

}  // namespace

Bytes fadecandy_frame(const FadecandyPixels& pixels) {
  Bytes content;
  for (const auto& rgb : pixels) content.insert(content.end(), rgb.begin(), rgb.end());
  return packets(0, content, kPacket - 1, 1);
}

Bytes fadecandy_lut(const FadecandyLut& lut) {
  Bytes content;
  for (const auto& channel : lut)
    for (const std::uint16_t entry : channel) {
      content.push_back(static_cast<std::uint8_t>(entry & 0xff));
      content.push_back(static_cast<std::uint8_t>(entry >> 8));
    }
  return packets(kLut, content, kPacket - 2, 2);
}

Bytes fadecandy_config(bool dither, bool interpolate) {
  Bytes out(kPacket);
  out[0] = kConfig;
  out[1] =
      static_cast<std::uint8_t>((dither ? 0 : kNoDither) | (interpolate ? 0 : kNoInterpolation));
  return out;
}

FadecandyLut fadecandy_response(double code_gamma, const std::array<double, 3>& response_gamma) {
  FadecandyLut lut{};
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < kFadecandyLutEntries; ++i) {
      // An 8-bit code is 257 times itself among the inputs: 255 is input 65535.
      const double code = std::min(1.0, static_cast<double>(i) * 256 / 65535);
      lut[c][i] = static_cast<std::uint16_t>(
          std::lround(65535 * std::pow(code, code_gamma / response_gamma[c])));
    }
  return lut;
}

}  // namespace wheatstone
