#include "capture/strict_object.h"

#include <algorithm>

namespace wheatstone {

namespace {
constexpr const char* kRemedy = "see docs/hdr_merge.md for this file";
}

StrictObject::StrictObject(const nlohmann::json& object, const std::filesystem::path& file,
                           std::string where, std::initializer_list<const char*> known)
    : object_(object), file_(file), where_(std::move(where)) {
  if (!object.is_object())
    throw FileError(file_, where_.empty() ? "is no JSON object" : where_ + " is no object",
                    kRemedy);
  for (const auto& [key, value] : object.items())
    if (std::find(known.begin(), known.end(), key) == known.end())
      fail(key, "is not a key of this file");
}

void StrictObject::fail(const std::string& key, const std::string& problem) const {
  throw FileError(file_, "key \"" + where_ + key + "\" " + problem, kRemedy);
}

const nlohmann::json& StrictObject::get(const std::string& key) const {
  if (!has(key)) fail(key, "is missing");
  return object_.at(key);
}

std::string StrictObject::text(const std::string& key) const {
  if (!get(key).is_string()) fail(key, "must be a text");
  return get(key);
}

double StrictObject::number_in(const nlohmann::json& value, const std::string& key) const {
  if (!value.is_number()) fail(key, "must be a number");
  return value.get<double>();  // JSON has no NaN or infinity
}

double StrictObject::number(const std::string& key) const {
  return number_in(get(key), key);
}

double StrictObject::positive(const std::string& key) const {
  const double value = number(key);
  if (!(value > 0)) fail(key, "must be above 0");
  return value;
}

int StrictObject::integer(const std::string& key, int lowest, int highest) const {
  const nlohmann::json& value = get(key);
  if (!value.is_number_integer() || value.get<double>() < lowest || value.get<double>() > highest)
    fail(key, "must be a whole number from " + std::to_string(lowest) + " to " +
                  std::to_string(highest));
  return value.get<int>();
}

}  // namespace wheatstone
