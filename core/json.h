#pragma once
// JSON files with a schema name and version, read strictly and written atomically.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/geometry.h"

namespace wheatstone {

/// Parses the file and checks that its "schema" is exactly `schema` ("wheatstone-poses/1").
/// Errors: FileError: missing, not JSON (with line and column), no schema, another schema or an
/// unknown version (says which versions this program reads).
nlohmann::json read_json(const std::filesystem::path&, const std::string& schema);

/// Parses a file that need not have a schema, such as other programs write.
/// Errors: FileError: missing, not JSON (with line and column).
nlohmann::json read_json(const std::filesystem::path&);

/// Adds "schema" and writes, indented, atomically. Numbers round-trip exactly. NaN and infinity
/// throw InternalError: JSON cannot hold them.
void write_json(const std::filesystem::path&, const std::string& schema, nlohmann::json);

/// Element access for readers; the error names the file, the key and the expected type.
/// T: double, int, std::uint64_t, bool, std::string, std::vector<...>, nlohmann::json.
template <class T>
T json_get(const nlohmann::json& object, const std::string& key, const std::filesystem::path& file);

nlohmann::json to_json(const Eigen::Vector2d&);
nlohmann::json to_json(const Eigen::Vector3d&);
nlohmann::json to_json(const Eigen::MatrixXd&);  // array of rows
Eigen::MatrixXd matrix_from_json(const nlohmann::json&, int rows, int cols,
                                 const std::filesystem::path& file, const std::string& key);
Eigen::Vector3d vector3_from_json(const nlohmann::json&, const std::filesystem::path& file,
                                  const std::string& key);
Eigen::Vector2d vector2_from_json(const nlohmann::json&, const std::filesystem::path& file,
                                  const std::string& key);

template <class T>
T json_get(const nlohmann::json& object, const std::string& key, const std::filesystem::path& file);

/// FileError for `key`; shared by the readers.
[[noreturn]] void throw_bad_key(const std::filesystem::path& file, const std::string& key,
                                const std::string& problem);

}  // namespace wheatstone

#include "core/json_inl.h"
