#pragma once
// What a capture leaves behind, to be compared byte by byte.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/files.h"

namespace wheatstone {

/// Contents by name of all that is the dataset's; session/ tells how it came about.
inline std::map<std::string, std::vector<std::byte>> dataset_contents(
    const std::filesystem::path& root) {
  std::map<std::string, std::vector<std::byte>> out;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root)) {
    const std::string name = std::filesystem::relative(entry.path(), root).string();
    if (entry.is_regular_file() && !name.starts_with("session/"))
      out[name] = read_bytes(entry.path());
  }
  return out;
}

}  // namespace wheatstone
