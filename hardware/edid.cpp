#include "hardware/edid.h"

#include <algorithm>
#include <array>
#include <string>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr std::array<unsigned, 8> kHead = {0, 255, 255, 255, 255, 255, 255, 0};
constexpr std::size_t kManufacturer = 8, kProduct = 10, kSerial = 12, kVersion = 18,
                      kDescriptors = 54, kDescriptorBytes = 18, kTextAt = 5, kTextBytes = 13;
constexpr unsigned kNameTag = 0xfc, kSerialTag = 0xff, kDummyTag = 0x10;

unsigned at(std::span<const std::byte> bytes, std::size_t i) {
  return std::to_integer<unsigned>(bytes[i]);
}

std::string text_of(std::span<const std::byte> descriptor) {
  std::string text;
  for (const std::byte b : descriptor.subspan(kTextAt, kTextBytes)) {
    const char c = static_cast<char>(b);
    if (c == '\n') break;
    text += c >= ' ' && c <= '~' ? c : '?';
  }
  text.erase(text.find_last_not_of(' ') + 1);
  return text;
}

void put_text(std::span<std::byte> descriptor, unsigned tag, const std::string& text) {
  descriptor[3] = static_cast<std::byte>(text.empty() ? kDummyTag : tag);
  if (text.empty()) return;
  for (std::size_t i = 0; i < kTextBytes; ++i)
    descriptor[kTextAt + i] = static_cast<std::byte>(i < text.size()    ? text[i]
                                                     : i == text.size() ? '\n'
                                                                        : ' ');
}

}  // namespace

std::optional<EdidIdentity> parse_edid(std::span<const std::byte> bytes) {
  if (bytes.size() < kEdidBlock) return std::nullopt;
  const std::span<const std::byte> block = bytes.first(kEdidBlock);
  unsigned sum = 0;
  for (std::size_t i = 0; i < kEdidBlock; ++i) {
    if (i < kHead.size() && at(block, i) != kHead[i]) return std::nullopt;
    sum += at(block, i);
  }
  if (sum % 256 != 0) return std::nullopt;
  EdidIdentity id;
  const unsigned letters = at(block, kManufacturer) << 8 | at(block, kManufacturer + 1);
  for (const unsigned shift : {10U, 5U, 0U}) {
    const unsigned letter = letters >> shift & 31;
    id.manufacturer += letter >= 1 && letter <= 26 ? static_cast<char>('A' + letter - 1) : '?';
  }
  id.product = static_cast<std::uint16_t>(at(block, kProduct) | at(block, kProduct + 1) << 8);
  for (std::size_t i = 0; i < 4; ++i)
    id.serial |= static_cast<std::uint32_t>(at(block, kSerial + i)) << (8 * i);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto descriptor = block.subspan(kDescriptors + i * kDescriptorBytes, kDescriptorBytes);
    if (at(descriptor, 0) || at(descriptor, 1) || at(descriptor, 2)) continue;  // a timing
    if (at(descriptor, 3) == kNameTag) id.name = text_of(descriptor);
    if (at(descriptor, 3) == kSerialTag) id.serial_text = text_of(descriptor);
  }
  return id;
}

std::vector<std::byte> compose_edid(const EdidIdentity& id) {
  if (id.manufacturer.size() != 3 || !std::all_of(id.manufacturer.begin(), id.manufacturer.end(),
                                                  [](char c) { return c >= 'A' && c <= 'Z'; }))
    throw ArgumentError("'" + id.manufacturer + "' is no EDID manufacturer",
                        "use three capital letters");
  if (id.name.size() > kTextBytes || id.serial_text.size() > kTextBytes)
    throw ArgumentError("a text of an EDID is too long", "use at most 13 characters");
  std::vector<std::byte> block(kEdidBlock);
  const auto put = [&](std::size_t i, std::uint32_t value) {
    block[i] = static_cast<std::byte>(value & 0xff);
  };
  for (std::size_t i = 0; i < kHead.size(); ++i) put(i, kHead[i]);
  std::uint32_t letters = 0;
  for (const char c : id.manufacturer)
    letters = letters << 5 | static_cast<std::uint32_t>(c - 'A' + 1);
  put(kManufacturer, letters >> 8);
  put(kManufacturer + 1, letters);
  put(kProduct, id.product);
  put(kProduct + 1, id.product >> 8U);
  for (std::size_t i = 0; i < 4; ++i) put(kSerial + i, id.serial >> (8 * i));
  put(kVersion, 1);
  put(kVersion + 1, 4);
  const std::array<std::pair<unsigned, std::string>, 4> texts = {
      {{kNameTag, id.name}, {kSerialTag, id.serial_text}, {kDummyTag, ""}, {kDummyTag, ""}}};
  for (std::size_t i = 0; i < 4; ++i)
    put_text(std::span(block).subspan(kDescriptors + i * kDescriptorBytes, kDescriptorBytes),
             texts[i].first, texts[i].second);
  unsigned sum = 0;
  for (const std::byte b : block) sum += std::to_integer<unsigned>(b);
  put(kEdidBlock - 1, 256 - sum % 256);
  return block;
}

}  // namespace wheatstone
