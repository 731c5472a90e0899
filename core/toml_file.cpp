#include "core/toml_file.h"

#include <toml++/toml.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/error.h"
#include "core/files.h"

namespace wheatstone {

namespace fs = std::filesystem;

struct TomlTable::Node {
  std::shared_ptr<const toml::table> root;  // keeps `table` alive
  const toml::table* table = nullptr;
  fs::path file;
  std::string manual, prefix;  // "stage."
  std::set<std::string> asked;
};

namespace {

/// Changes of one letter that turn one into the other.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j)
      diagonal = std::exchange(row[j + 1],
                               std::min({row[j + 1] + 1, row[j] + 1, diagonal + (a[i] != b[j])}));
  }
  return row.back();
}

/// One may be a slip of the pen for the other.
bool alike(const std::string& a, const std::string& b) {
  return edit_distance(a, b) <= std::max<std::size_t>(2, b.size() / 3);
}

}  // namespace

TomlTable TomlTable::read(const fs::path& file, const std::string& manual) {
  const std::string remedy = "see " + manual;
  auto node = std::make_shared<Node>();
  node->file = file;
  node->manual = manual;
  try {
    node->root = std::make_shared<const toml::table>(
        toml::parse(read_text(file, std::size_t{1} << 20), file.string()));
  } catch (const toml::parse_error& e) {
    throw FileError(file,
                    fmt::format("line {}: is not valid TOML: {}", e.source().begin.line,
                                std::string(e.description())),
                    remedy);
  }
  node->table = node->root.get();
  return TomlTable(std::move(node));
}

void TomlTable::fail(const std::string& key, const std::string& problem,
                     const std::string& remedy) const {
  const toml::node* at = node_->table->get(key);
  const auto line = (at ? at->source() : node_->table->source()).begin.line;
  throw FileError(node_->file,
                  fmt::format("line {}: key \"{}{}\" {}", line, node_->prefix, key, problem),
                  remedy.empty() ? "see " + node_->manual : remedy);
}

void TomlTable::fail_missing(const std::string& key) const {
  for (const auto& [name, value] : *node_->table)
    if (const std::string there(name.str()); !node_->asked.contains(there) && alike(there, key))
      fail(there, "is not a key of this table", "use \"" + key + "\"");
  fail(key, "is missing");
}

std::string TomlTable::place() const {
  return fmt::format("{}, line {}", node_->file.string(), node_->table->source().begin.line);
}

bool TomlTable::has(const std::string& key) const {
  node_->asked.insert(key);
  return node_->table->contains(key);
}

std::string TomlTable::text(const std::string& key) const {
  if (!has(key)) fail_missing(key);
  const auto value = (*node_->table)[key].value_exact<std::string>();
  if (!value || value->empty()) fail(key, "must be a text in quotes");
  return *value;
}

std::string TomlTable::text_or(const std::string& key, const std::string& absent) const {
  return has(key) ? text(key) : absent;
}

double TomlTable::number(const std::string& key, double lowest, double highest) const {
  if (!has(key)) fail_missing(key);
  const toml::node& node = *node_->table->get(key);
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (!value || !std::isfinite(*value) || *value < lowest || *value > highest)
    fail(key, fmt::format("must be a number from {} to {}", lowest, highest));
  return *value;
}

double TomlTable::number_or(const std::string& key, double absent, double lowest,
                            double highest) const {
  return has(key) ? number(key, lowest, highest) : absent;
}

std::int64_t TomlTable::integer(const std::string& key, std::int64_t lowest,
                                std::int64_t highest) const {
  if (!has(key)) fail_missing(key);
  const auto value = (*node_->table)[key].value_exact<std::int64_t>();
  if (!value || *value < lowest || *value > highest)
    fail(key, fmt::format("must be a whole number from {} to {}", lowest, highest));
  return *value;
}

std::int64_t TomlTable::integer_or(const std::string& key, std::int64_t absent, std::int64_t lowest,
                                   std::int64_t highest) const {
  return has(key) ? integer(key, lowest, highest) : absent;
}

bool TomlTable::flag_or(const std::string& key, bool absent) const {
  if (!has(key)) return absent;
  const auto value = (*node_->table)[key].value_exact<bool>();
  if (!value) fail(key, "must be true or false");
  return *value;
}

void TomlTable::read_numbers(const std::string& key, double lowest, double highest,
                             std::span<double> out) const {
  if (!has(key)) fail_missing(key);
  const toml::array* list = (*node_->table)[key].as_array();
  for (std::size_t i = 0; i < out.size(); ++i) {
    const bool there = list && list->size() == out.size() && (*list)[i].is_number();
    out[i] = there ? *(*list)[i].value<double>() : std::nan("");
    if (!(out[i] >= lowest && out[i] <= highest))
      fail(key,
           fmt::format("must be a list of {} numbers from {} to {}", out.size(), lowest, highest));
  }
}

std::vector<std::array<double, 3>> TomlTable::points(const std::string& key) const {
  if (!has(key)) fail_missing(key);
  const auto refuse = [&] { fail(key, "must be a list of points like [10.0, 20.0, 0.0]"); };
  const toml::array* list = (*node_->table)[key].as_array();
  if (!list || list->size() > 1000) refuse();
  std::vector<std::array<double, 3>> out;
  for (const toml::node& entry : *list) {
    const toml::array* point = entry.as_array();
    if (!point || point->size() != 3) refuse();
    std::array<double, 3> p{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto value = (*point)[i].is_number() ? (*point)[i].value<double>() : std::nullopt;
      if (!value || !std::isfinite(*value)) refuse();
      p[i] = *value;
    }
    out.push_back(p);
  }
  return out;
}

fs::path TomlTable::file(const std::string& key) const {
  const fs::path path = node_->file.parent_path() / text(key);
  std::error_code error;
  if (!fs::is_regular_file(path, error))
    fail(key, "names " + path.string() + ", which is not there",
         "make that file or correct its name");
  return path;
}

std::vector<std::string> TomlTable::table_names() const {
  std::vector<std::string> names;
  for (const auto& [key, value] : *node_->table)
    if (value.is_table()) names.emplace_back(key.str());
  return names;
}

TomlTable TomlTable::table(const std::string& key) const {
  if (!has(key)) fail_missing(key);
  const toml::table* table = (*node_->table)[key].as_table();
  if (!table) fail(key, "must be a table");
  return TomlTable(std::make_shared<Node>(
      Node{node_->root, table, node_->file, node_->manual, node_->prefix + key + ".", {}}));
}

std::vector<TomlTable> TomlTable::tables(const std::string& key) const {
  std::vector<TomlTable> out;
  if (!has(key)) return out;
  const toml::array* list = (*node_->table)[key].as_array();
  if (!list || !list->is_homogeneous(toml::node_type::table))
    fail(key, "must be tables [[" + key + "]]");
  for (std::size_t i = 0; i < list->size(); ++i)
    out.push_back(
        TomlTable(std::make_shared<Node>(Node{node_->root,
                                              (*list)[i].as_table(),
                                              node_->file,
                                              node_->manual,
                                              fmt::format("{}{}[{}].", node_->prefix, key, i),
                                              {}})));
  return out;
}

void TomlTable::finish() const {
  for (const auto& [name, value] : *node_->table) {
    const std::string key(name.str());
    if (node_->asked.contains(key)) continue;
    const std::string* nearest = nullptr;
    for (const std::string& known : node_->asked)
      if (alike(key, known) &&
          (!nearest || edit_distance(key, known) < edit_distance(key, *nearest)))
        nearest = &known;
    fail(key, "is not a key of this table",
         nearest ? "use \"" + *nearest + "\"" : "remove it, or see " + node_->manual);
  }
}

}  // namespace wheatstone
