#pragma once
// Numbers in the byte order of USB and of the emulated camera's files.

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace wheatstone {

template <std::integral T>
void append(std::vector<std::byte>& out, T value) {
  for (std::size_t i = 0; i < sizeof value; ++i)
    out.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * i)));
}

/// Pre: at least that many bytes.
template <std::unsigned_integral T>
T number_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i)
    value |= std::to_integer<std::uint64_t>(bytes[at + i]) << (8 * i);
  return static_cast<T>(value);
}

}  // namespace wheatstone
