#include "hardware/serial/photodiode_message.h"

#include <fmt/format.h>

#include <charconv>

#include "hardware/device_error.h"
#include "hardware/transport/transcript.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr std::size_t kHeadBytes = 3, kCrcBytes = 2;

std::uint16_t word_at(std::string_view bytes, std::size_t at) {
  return static_cast<std::uint16_t>(static_cast<unsigned char>(bytes[at]) |
                                    static_cast<unsigned char>(bytes[at + 1]) << 8);
}

void append(std::string& bytes, std::uint16_t word) {
  bytes += static_cast<char>(word & 0xff);
  bytes += static_cast<char>(word >> 8);
}

DeviceError nonsense(const std::string& what, std::string_view bytes) {
  return {Kind::kProtocol,
          fmt::format("{} sends what is not of its protocol: {}", what, hex_of(bytes)),
          "check that this is the right device and its cable"};
}

}  // namespace

std::uint16_t crc16(std::string_view bytes) {
  unsigned crc = 0xffff;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned>(static_cast<unsigned char>(c)) << 8;
    for (int bit = 0; bit < 8; ++bit) crc = crc << 1 ^ (crc & 0x8000 ? 0x1021 : 0);
  }
  return static_cast<std::uint16_t>(crc);
}

std::string encode(const PhotodiodeBlock& block) {
  std::string bytes = {static_cast<char>(PhotodiodeBlock::kStart),
                       static_cast<char>(block.sequence), static_cast<char>(block.samples.size())};
  for (const std::uint16_t s : block.samples) append(bytes, s);
  append(bytes, crc16(std::string_view(bytes).substr(1)));
  return bytes;
}

std::vector<PhotodiodeBlock> take_blocks(const std::string& what, std::string& bytes) {
  std::vector<PhotodiodeBlock> out;
  std::string_view rest = bytes;
  while (!rest.empty()) {
    if (static_cast<unsigned char>(rest[0]) != PhotodiodeBlock::kStart) throw nonsense(what, rest);
    if (rest.size() < kHeadBytes) break;
    const auto count = static_cast<std::size_t>(static_cast<unsigned char>(rest[2]));
    if (count == 0 || count > PhotodiodeBlock::kMostSamples) throw nonsense(what, rest);
    const std::size_t checked = kHeadBytes + 2 * count, size = checked + kCrcBytes;
    if (rest.size() < size) break;
    if (crc16(rest.substr(1, checked - 1)) != word_at(rest, checked)) throw nonsense(what, rest);
    PhotodiodeBlock block{static_cast<std::uint8_t>(rest[1]), {}};
    for (std::size_t i = 0; i < count; ++i)
      block.samples.push_back(word_at(rest, kHeadBytes + 2 * i));
    out.push_back(std::move(block));
    rest.remove_prefix(size);
  }
  bytes.erase(0, bytes.size() - rest.size());
  return out;
}

std::vector<std::uint32_t> numbers_of(const std::string& what, std::string_view answer,
                                      std::string_view word, std::size_t count) {
  if (answer.starts_with("ERROR "))
    throw DeviceError(Kind::kRefused, fmt::format("{} says: {}", what, printable(answer.substr(6))),
                      "run the command again");
  if (!answer.starts_with(word)) throw nonsense(what, answer);
  std::vector<std::uint32_t> out;
  const char* at = answer.data() + word.size();
  const char* end = answer.data() + answer.size();
  while (at != end && *at == ' ') {
    std::uint32_t value = 0;
    const auto [next, error] = std::from_chars(at + 1, end, value);
    if (error != std::errc{}) throw nonsense(what, answer);
    out.push_back(value);
    at = next;
  }
  if (at != end || out.size() != count) throw nonsense(what, answer);
  return out;
}

}  // namespace wheatstone
