#pragma once
// Options that several subcommands of `wheatstone quality` share.

#include <CLI/App.hpp>
#include <functional>
#include <string>

#include "core/csv.h"
#include "rendering/motion_quality/experiments.h"

namespace wheatstone::apps {

/// --input, --output and --json of a command that adds result columns to a table.
struct TableOptions {
  std::string input, output;
  bool json = false;

  void add_to(CLI::App& command);
  /// Writes the table; with --json also prints its rows as JSON objects (null for NaN).
  void finish(const CsvTable&) const;
};

/// compute(row) for every row; what it says about impossible values names file and line.
void for_each_row(const CsvTable&, const std::function<void(std::size_t row)>& compute);

/// --preset released|published.
void add_preset_option(CLI::App& command, std::string& preset);

/// --data and --textures: folders of the published measurements.
struct ExperimentOptions {
  std::string data, textures;

  void add_to(CLI::App& command);
  /// Folders not given are looked for below WHEATSTONE_SHARED, if that is set.
  /// Errors: ArgumentError naming the option to give; those of read_quality_experiments.
  QualityExperiments read() const;
};

}  // namespace wheatstone::apps
