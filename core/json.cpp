#include "core/json.h"

#include <cmath>

#include "core/error.h"
#include "core/files.h"

namespace wheatstone {

using nlohmann::json;

namespace {
void require_finite(const json& value) {
  if (value.is_number_float() && !std::isfinite(value.get<double>()))
    throw InternalError("a number that is not finite was about to be written to JSON");
  if (value.is_structured())
    for (const json& child : value) require_finite(child);
}
}  // namespace

json read_json(const std::filesystem::path& path) {
  try {
    return json::parse(read_text(path));
  } catch (const json::exception& e) {
    throw FileError(path, std::string("is not valid JSON: ") + e.what(),
                    "restore the file or run the step that writes it again");
  }
}

json read_json(const std::filesystem::path& path, const std::string& schema) {
  const json document = read_json(path);
  if (!document.is_object() || !document.contains("schema") || !document["schema"].is_string())
    throw FileError(path, "has no \"schema\"",
                    "this program reads \"" + schema + "\"; add that key if the file follows it");
  const std::string found = document["schema"];
  if (found != schema)
    throw FileError(path, "has schema \"" + found + "\", this program reads \"" + schema + "\"",
                    "use the program version that wrote it, or write it again with this one");
  return document;
}

void write_json(const std::filesystem::path& path, const std::string& schema, json document) {
  document["schema"] = schema;
  require_finite(document);
  write_text_atomically(path, document.dump(2) + "\n");
}

void throw_bad_key(const std::filesystem::path& file, const std::string& key,
                   const std::string& problem) {
  throw FileError(file, "key \"" + key + "\" " + problem, "see docs/dataset.md for this file");
}

json to_json(const Eigen::Vector2d& v) {
  return {v.x(), v.y()};
}
json to_json(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

json to_json(const Eigen::MatrixXd& m) {
  json rows = json::array();
  for (Eigen::Index r = 0; r < m.rows(); ++r) {
    json row = json::array();
    for (Eigen::Index c = 0; c < m.cols(); ++c) row.push_back(m(r, c));
    rows.push_back(row);
  }
  return rows;
}

Eigen::MatrixXd matrix_from_json(const json& value, int rows, int cols,
                                 const std::filesystem::path& file, const std::string& key) {
  const std::string shape =
      "must be " + std::to_string(rows) + " rows of " + std::to_string(cols) + " numbers";
  if (!value.is_array() || value.size() != static_cast<std::size_t>(rows))
    throw_bad_key(file, key, shape);
  Eigen::MatrixXd m(rows, cols);
  for (int r = 0; r < rows; ++r) {
    if (!value[r].is_array() || value[r].size() != static_cast<std::size_t>(cols))
      throw_bad_key(file, key, shape);
    for (int c = 0; c < cols; ++c) {
      if (!value[r][c].is_number()) throw_bad_key(file, key, shape);
      m(r, c) = value[r][c].get<double>();
    }
  }
  return m;
}

Eigen::Vector3d vector3_from_json(const json& value, const std::filesystem::path& file,
                                  const std::string& key) {
  return matrix_from_json(json::array({value}), 1, 3, file, key).transpose();
}

Eigen::Vector2d vector2_from_json(const json& value, const std::filesystem::path& file,
                                  const std::string& key) {
  return matrix_from_json(json::array({value}), 1, 2, file, key).transpose();
}

}  // namespace wheatstone
