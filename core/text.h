#pragma once
// Words for people.

#include <concepts>
#include <string>

namespace wheatstone {

/// "1 view", "2 views", "0 views"; for nouns that only take an s.
template <std::integral Count>
std::string counted(Count count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

}  // namespace wheatstone
