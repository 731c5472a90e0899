#pragma once
// TOML that people write for the program: every key known, every value of its kind.

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace wheatstone {

/// One table of a file. Read what is expected, then finish(). Every error is a FileError that names
/// the file, the line and the key ("stage.travel_mm"). Copies share what has been read.
class TomlTable {
 public:
  /// The whole file. Throws for a missing file, one above 1 MiB or without TOML's syntax.
  /// `manual` is where the remedy points ("docs/rig_file.md").
  static TomlTable read(const std::filesystem::path&, const std::string& manual);

  bool has(const std::string& key) const;
  std::string text(const std::string& key) const;
  std::string text_or(const std::string& key, const std::string& absent) const;
  /// Finite and within [lowest, highest].
  double number(const std::string& key, double lowest, double highest) const;
  double number_or(const std::string& key, double absent, double lowest, double highest) const;
  std::int64_t integer(const std::string& key, std::int64_t lowest, std::int64_t highest) const;
  std::int64_t integer_or(const std::string& key, std::int64_t absent, std::int64_t lowest,
                          std::int64_t highest) const;
  bool flag_or(const std::string& key, bool absent) const;
  /// A list of N numbers, each within [lowest, highest].
  template <std::size_t N>
  std::array<double, N> numbers(const std::string& key, double lowest, double highest) const {
    std::array<double, N> out;
    read_numbers(key, lowest, highest, out);
    return out;
  }
  /// A list of points of three finite numbers.
  std::vector<std::array<double, 3>> points(const std::string& key) const;
  /// An existing file, relative to the folder of this one.
  std::filesystem::path file(const std::string& key) const;

  std::vector<std::string> table_names() const;
  TomlTable table(const std::string& key) const;
  /// Of an array of tables; empty if there is none.
  std::vector<TomlTable> tables(const std::string& key) const;

  /// Refuses every key of this table that nobody has asked for, with the nearest one that would be
  /// known.
  void finish() const;
  [[noreturn]] void fail(const std::string& key, const std::string& problem,
                         const std::string& remedy = {}) const;
  /// "rig.toml, line 12".
  std::string place() const;

 private:
  struct Node;
  void read_numbers(const std::string& key, double lowest, double highest, std::span<double>) const;
  [[noreturn]] void fail_missing(const std::string& key) const;
  explicit TomlTable(std::shared_ptr<Node> node) : node_(std::move(node)) {}

  std::shared_ptr<Node> node_;
};

}  // namespace wheatstone
