#pragma once
// One part of a list of independent items, so that many processes can share the work.

#include <cstddef>
#include <string>

namespace wheatstone::apps {

/// Items k of a list with k % count == index - 1.
struct Shard {
  int index = 1, count = 1;

  bool holds(std::size_t k) const {
    return k % static_cast<std::size_t>(count) == static_cast<std::size_t>(index - 1);
  }
};

/// From i/N such as "2/8". Throws ArgumentError unless 1 <= i <= N.
Shard shard_from_string(const std::string&);

}  // namespace wheatstone::apps
