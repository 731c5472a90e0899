#pragma once

#include "core/json.h"

namespace wheatstone {

template <class T>
T json_get(const nlohmann::json& object, const std::string& key,
           const std::filesystem::path& file) {
  if (!object.is_object() || !object.contains(key)) throw_bad_key(file, key, "is missing");
  try {
    return object.at(key).get<T>();
  } catch (const nlohmann::json::exception& e) {
    throw_bad_key(file, key, std::string("has the wrong type (") + e.what() + ")");
  }
}

}  // namespace wheatstone
