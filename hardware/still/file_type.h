#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

namespace wheatstone {

/// How the name of a picture ends, in capitals: "ARW"; empty if it does not.
inline std::string file_type_of(const std::filesystem::path& name) {
  std::string type = name.extension();
  if (!type.empty()) type.erase(0, 1);
  std::transform(type.begin(), type.end(), type.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return type;
}

}  // namespace wheatstone
