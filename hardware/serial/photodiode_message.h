#pragma once
// The bytes of the photodiode's protocol (docs/hardware/photodiode.md).

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace wheatstone {

/// A run of samples. On the wire: 0xa5, sequence, count, the samples with the low byte first, and
/// CRC-16/CCITT-FALSE (low byte first) over all between the first byte and itself.
struct PhotodiodeBlock {
  static constexpr unsigned char kStart = 0xa5;
  static constexpr std::size_t kMostSamples = 64;

  std::uint8_t sequence = 0;  // one more each block, wraps
  std::vector<std::uint16_t> samples;
};

std::uint16_t crc16(std::string_view);
/// Pre: 1 to kMostSamples samples.
std::string encode(const PhotodiodeBlock&);
/// Takes the whole blocks off the front of `bytes`. Throws DeviceError kProtocol, `what` in front,
/// for anything that cannot be one.
std::vector<PhotodiodeBlock> take_blocks(const std::string& what, std::string& bytes);

/// An answer "WORD 12 34": the numbers, as many as asked for. Throws kRefused for "ERROR text",
/// kProtocol for anything else.
std::vector<std::uint32_t> numbers_of(const std::string& what, std::string_view answer,
                                      std::string_view word, std::size_t count);

}  // namespace wheatstone
