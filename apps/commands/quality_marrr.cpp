#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/quality.h"
#include "apps/commands/quality_options.h"
#include "core/error.h"
#include "rendering/motion_quality/marrr.h"

namespace wheatstone::apps {
namespace {

Marrr model_for(const CsvTable& t, std::size_t row, MotionQualityPreset preset) {
  const double predictable = t.finite_number(row, "predictable");
  if (predictable != 0 && predictable != 1)
    throw ArgumentError(fmt::format("predictable is {}", predictable),
                        "give 1 for motion that the viewer can foresee, 0 otherwise");
  return Marrr(preset, predictable == 1 ? Motion::kPredictable : Motion::kUnpredictable);
}

double positive(const CsvTable& t, std::size_t row, const std::string& column) {
  const double value = t.finite_number(row, column);
  if (!(value > 0))
    throw ArgumentError(fmt::format("{} of {} is not positive", column, value), "give one above 0");
  return value;
}

/// Display A of a row against display B, which shows full resolution.
double quality(const CsvTable& t, std::size_t row, MotionQualityPreset preset) {
  const double reduction = positive(t, row, "resolution_reductionA");
  if (reduction > 1)
    throw ArgumentError(fmt::format("resolution_reductionA of {} is above 1", reduction),
                        "give the part of the native width that is rendered");
  const double native_ppd = positive(t, row, "native_width_px") / positive(t, row, "fov_deg"),
               persistence = t.finite_number(row, "persistence");
  const MarrrDisplay a{t.finite_number(row, "refreshA_hz"), native_ppd * reduction, persistence},
      b{t.finite_number(row, "refreshB_hz"), native_ppd, persistence};
  return model_for(t, row, preset)
      .quality_difference_jnd(a, b, t.finite_number(row, "velocity_deg_s"));
}

void add_comparison(CLI::App& quality_noun) {
  auto* command = quality_noun.add_subcommand(
      "marrr", "MARRR: quality Q (JND) of a refresh rate and resolution above another");
  auto table = std::make_shared<TableOptions>();
  auto preset = std::make_shared<std::string>("released");
  table->add_to(*command);
  add_preset_option(*command, *preset);
  command->footer(
      "Columns: refreshA_hz, resolution_reductionA, refreshB_hz, native_width_px, fov_deg,\n"
      "velocity_deg_s, predictable (1 or 0), persistence. B has full resolution.\n"
      "Example:\n  wheatstone quality marrr --input ../shared/reference/perception/vectors/"
      "marrr_quality.csv --output out/quality.csv");
  command->callback([=] {
    const MotionQualityPreset chosen = motion_quality_preset_from_string(*preset);
    CsvTable t = CsvTable::read(table->input);
    std::vector<double> q(t.rows());
    for_each_row(t, [&](std::size_t row) { q[row] = quality(t, row, chosen); });
    t.set_column("Q", q);
    table->finish(t);
  });
}

void add_optimum(CLI::App& quality_noun) {
  auto* command = quality_noun.add_subcommand(
      "marrr-optimum", "MARRR: the best refresh rate and resolution for speed and pixel budget");
  auto table = std::make_shared<TableOptions>();
  auto preset = std::make_shared<std::string>("released");
  auto budget = std::make_shared<MarrrBudget>();
  table->add_to(*command);
  add_preset_option(*command, *preset);
  command->add_option("--native-ppd", budget->native_ppd, "pixels per degree at full resolution")
      ->capture_default_str();
  command->add_option("--persistence", budget->persistence, "lit part of the frame, (0, 1]")
      ->capture_default_str();
  command->add_option("--min-hz", budget->min_refresh_hz, "least refresh rate")
      ->capture_default_str();
  command->add_option("--max-hz", budget->max_refresh_hz, "greatest refresh rate")
      ->capture_default_str();
  command->footer(
      "Columns: bandwidth_fraction (of full resolution at the greatest rate), velocity_deg_s,\n"
      "predictable (1 or 0). Results: best_refresh_hz, resolution_reduction, Q_vs_reference.\n"
      "Example:\n  wheatstone quality marrr-optimum --input ../shared/reference/perception/vectors/"
      "marrr_optimum.csv --output out/best.csv");
  command->callback([=] {
    const MotionQualityPreset chosen = motion_quality_preset_from_string(*preset);
    CsvTable t = CsvTable::read(table->input);
    std::vector<double> refresh(t.rows()), reduction(t.rows()), q(t.rows());
    for_each_row(t, [&](std::size_t row) {
      MarrrBudget b = *budget;
      b.fraction = t.finite_number(row, "bandwidth_fraction");
      const MarrrOptimum o =
          model_for(t, row, chosen).optimum(b, t.finite_number(row, "velocity_deg_s"));
      refresh[row] = o.refresh_hz;
      reduction[row] = o.resolution_reduction;
      q[row] = o.quality_jnd;
    });
    t.set_column("best_refresh_hz", refresh);
    t.set_column("resolution_reduction", reduction);
    t.set_column("Q_vs_reference", q);
    table->finish(t);
  });
}

}  // namespace

void add_quality_marrr(CLI::App& quality_noun) {
  add_comparison(quality_noun);
  add_optimum(quality_noun);
}

}  // namespace wheatstone::apps
