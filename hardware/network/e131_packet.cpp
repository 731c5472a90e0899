#include "hardware/network/e131_packet.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace wheatstone {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kDataBytes = 126, kSyncBytes = 49;
constexpr std::size_t kNameAt = 44, kNameBytes = 64;

void put(Bytes& out, std::size_t at, std::size_t value, std::size_t bytes) {
  for (std::size_t i = 0; i < bytes; ++i)
    out[at + i] = static_cast<std::uint8_t>(value >> (8 * (bytes - 1 - i)));
}

/// Of the layer that begins at `at` and, as all do, goes to the end.
void put_length(Bytes& out, std::size_t at) {
  put(out, at, 0x7000 | (out.size() - at), 2);
}

/// A packet of `size` bytes with its root layer.
Bytes root_layer(const E131Source& source, std::size_t vector, std::size_t size) {
  constexpr std::string_view kPacketId = "ASC-E1.17";
  Bytes out(size);
  put(out, 0, 0x0010, 2);  // preamble
  std::copy(kPacketId.begin(), kPacketId.end(), out.begin() + 4);
  put_length(out, 16);
  put(out, 18, vector, 4);
  std::copy(source.id.begin(), source.id.end(), out.begin() + 22);
  put_length(out, 38);
  return out;
}

}  // namespace

Bytes e131_data(const E131Source& source, int universe, int sync_universe,
                std::span<const std::uint8_t> slots) {
  Bytes out = root_layer(source, 0x00000004, kDataBytes + slots.size());
  put(out, 40, 0x00000002, 4);
  const std::string name = source.name.substr(0, kNameBytes - 1);
  std::copy(name.begin(), name.end(), out.begin() + kNameAt);
  put(out, 108, static_cast<std::size_t>(source.priority), 1);
  put(out, 109, static_cast<std::size_t>(sync_universe), 2);
  put(out, 113, static_cast<std::size_t>(universe), 2);
  put_length(out, 115);
  put(out, 117, 0x02a1, 2);            // set property; addresses of two bytes
  put(out, 121, 1, 2);                 // their increment
  put(out, 123, slots.size() + 1, 2);  // with the start code, 0
  std::copy(slots.begin(), slots.end(), out.begin() + kDataBytes);
  return out;
}

Bytes e131_sync(const E131Source& source, int sync_universe) {
  Bytes out = root_layer(source, 0x00000008, kSyncBytes);
  put(out, 40, 0x00000001, 4);
  put(out, 45, static_cast<std::size_t>(sync_universe), 2);
  return out;
}

std::string e131_multicast_address(int universe) {
  return fmt::format("239.255.{}.{}", universe >> 8, universe & 0xff);
}

}  // namespace wheatstone
