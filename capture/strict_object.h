#pragma once
// JSON objects that people write for the program: every key known, every value of its kind.

#include <array>
#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>

#include "core/error.h"

namespace wheatstone {

/// One object of a file. Every error is a FileError that names the file and the key, as
/// `where` + key, and points to docs/hdr_merge.md. The JSON must outlive it.
class StrictObject {
 public:
  /// Refuses keys that are not `known`.
  StrictObject(const nlohmann::json& object, const std::filesystem::path& file, std::string where,
               std::initializer_list<const char*> known);

  bool has(const std::string& key) const { return object_.contains(key); }
  const nlohmann::json& get(const std::string& key) const;
  std::string text(const std::string& key) const;
  double number(const std::string& key) const;
  double positive(const std::string& key) const;
  int integer(const std::string& key, int lowest, int highest) const;
  template <std::size_t N>
  std::array<double, N> numbers(const std::string& key) const {
    const nlohmann::json& list = get(key);
    if (!list.is_array() || list.size() != N)
      fail(key, "must be a list of " + std::to_string(N) + " numbers");
    std::array<double, N> out;
    for (std::size_t i = 0; i < N; ++i) out[i] = number_in(list[i], key);
    return out;
  }
  [[noreturn]] void fail(const std::string& key, const std::string& problem) const;

 private:
  double number_in(const nlohmann::json&, const std::string& key) const;

  const nlohmann::json& object_;
  std::filesystem::path file_;
  std::string where_;
};

}  // namespace wheatstone
