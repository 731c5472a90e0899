#include "apps/shard.h"

#include <charconv>

#include "core/error.h"

namespace wheatstone::apps {

Shard shard_from_string(const std::string& text) {
  Shard out;
  const auto number = [&](std::size_t begin, std::size_t end, int& value) {
    const auto [parsed_to, error] = std::from_chars(text.data() + begin, text.data() + end, value);
    return error == std::errc() && parsed_to == text.data() + end;
  };
  const auto slash = text.find('/');
  if (slash == std::string::npos || !number(0, slash, out.index) ||
      !number(slash + 1, text.size(), out.count) || out.index < 1 || out.count < out.index)
    throw ArgumentError("'" + text + "' is no shard", "write i/N with 1 <= i <= N, such as 2/8");
  return out;
}

}  // namespace wheatstone::apps
