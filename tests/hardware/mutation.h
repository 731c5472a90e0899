#pragma once

#include <algorithm>
#include <string>

#include "core/random.h"

namespace wheatstone {

/// A valid message with up to four bytes changed, put in or taken out, or its end cut off; one in
/// sixteen is random bytes altogether.
inline std::string mutated(std::string bytes, RandomStream& random) {
  const auto below = [&](std::size_t n) { return n ? random.next() % n : 0; };
  const auto byte = [&] { return static_cast<char>(random.next() & 0xff); };
  if (below(16) == 0) {
    bytes.resize(below(bytes.size() + 1));
    std::generate(bytes.begin(), bytes.end(), byte);
    return bytes;
  }
  for (std::size_t n = below(5); n > 0; --n) {
    const std::size_t at = below(bytes.size());
    switch (below(4)) {
      case 0:
        if (!bytes.empty()) bytes[at] = byte();
        break;
      case 1:
        if (!bytes.empty()) bytes[at] = static_cast<char>('0' + below(10));
        break;
      case 2:
        bytes.insert(at, 1, byte());
        break;
      default:
        bytes.erase(at, below(6) == 0 ? std::string::npos : 1);
    }
  }
  return bytes;
}

}  // namespace wheatstone
