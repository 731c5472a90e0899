#include "apps/commands/quality_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace wheatstone::apps {
namespace {

/// A cell as a machine wants it: a number if it is one, null for NaN and infinity, else text.
nlohmann::json json_cell(const CsvTable& t, std::size_t row, const std::string& column) {
  try {
    const double value = t.number(row, column);
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
  } catch (const FileError&) {
    return t.text(row, column);
  }
}

/// The folder given, or the one of that name in the shared data.
std::string folder_or_shared(const std::string& given, const std::string& option,
                             const std::string& name) {
  if (!given.empty()) return given;
  const char* shared = std::getenv("WHEATSTONE_SHARED");
  const std::filesystem::path found =
      std::filesystem::path(shared ? shared : "") / "reference" / "perception" / name;
  if (shared && std::filesystem::is_directory(found)) return found.string();
  throw ArgumentError("no folder of published " + name + " is known",
                      "give " + option + " DIR, or set WHEATSTONE_SHARED to the shared folder");
}

}  // namespace

void TableOptions::add_to(CLI::App& command) {
  command.add_option("--input", input, "CSV table, one row for each evaluation")->required();
  command
      .add_option("--output", output,
                  "CSV table to write: all columns of the input and the results")
      ->required();
  command.add_flag("--json", json, "also the rows as JSON on standard output");
}

void TableOptions::finish(const CsvTable& table) const {
  table.write(output);
  if (!json) return;
  nlohmann::json rows = nlohmann::json::array();
  for (std::size_t i = 0; i < table.rows(); ++i) {
    nlohmann::json row;
    for (const std::string& column : table.columns()) row[column] = json_cell(table, i, column);
    rows.push_back(std::move(row));
  }
  fmt::print("{}\n", rows.dump(1));
}

void for_each_row(const CsvTable& table, const std::function<void(std::size_t row)>& compute) {
  for (std::size_t row = 0; row < table.rows(); ++row) {
    try {
      compute(row);
    } catch (const ArgumentError& e) {
      throw ArgumentError(table.where(row) + ": " + e.what(), "");
    }
  }
}

void add_preset_option(CLI::App& command, std::string& preset) {
  command.add_option("--preset", preset, "released (programs) or published (thesis's equations)")
      ->capture_default_str();
}

void ExperimentOptions::add_to(CLI::App& command) {
  command.add_option("--data", data, "folder of the published measurements (CSV)");
  command.add_option("--textures", textures, "folder of their textures (EXR)");
}

QualityExperiments ExperimentOptions::read() const {
  const std::string measured = folder_or_shared(data, "--data", "data");
  return read_quality_experiments(measured, folder_or_shared(textures, "--textures", "textures"));
}

}  // namespace wheatstone::apps
