#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/quality.h"
#include "rendering/motion_quality/alsarr/refresh_table.h"
#include "rendering/motion_quality/grey_texture.h"

namespace wheatstone::apps {
namespace {

struct Options {
  std::string texture, output, candidates;
  std::vector<double> budgets = {0.0625, 0.25}, speeds_deg_per_s = {0, 12.5, 25, 37.5, 50};
  RefreshSearch search;
};

void write_refresh_table(const Options& o) {
  const RefreshTable table(Camojab(CamojabTexture(read_grey_texture(o.texture))), o.budgets,
                           o.speeds_deg_per_s, o.search);
  table.write(o.output);
  if (!o.candidates.empty()) table.write_candidates(o.candidates);
  for (const RefreshEntry& e : table.entries())
    fmt::print("budget {:g}, {:g} deg/s: {:g} Hz\n", e.budget_fraction, e.speed_deg_per_s,
               e.best_refresh_hz);
}

}  // namespace

void add_quality_refresh(CLI::App& quality) {
  auto* command = quality.add_subcommand(
      "refresh", "Best refresh rate for a speed and a budget of pixels per second");
  auto o = std::make_shared<Options>();
  command->add_option("--texture", o->texture, "EXR (Y or R, G, B) or 8- or 16-bit picture")
      ->required();
  command->add_option("--output", o->output, "CSV: the best rates")->required();
  command->add_option("--candidates", o->candidates, "CSV: quality at every rate");
  command->add_option("--budget", o->budgets, "fractions of full resolution at --max-hz")
      ->capture_default_str();
  command->add_option("--speed-deg-per-s", o->speeds_deg_per_s, "speeds")->capture_default_str();
  command->add_option("--min-hz", o->search.min_refresh_hz, "lowest rate")->capture_default_str();
  command->add_option("--max-hz", o->search.max_refresh_hz, "highest rate")->capture_default_str();
  command->add_option("--step-hz", o->search.step_hz, "between rates")->capture_default_str();
  command->add_option("--ppd", o->search.ppd, "pixels per degree")->capture_default_str();
  command->add_option("--luminance-cd-m2", o->search.luminance_cd_m2, "mean luminance")
      ->capture_default_str();
  command->add_option("--persistence", o->search.persistence, "lit part of a frame, up to 1")
      ->capture_default_str();
  command->add_option("--mip-level", o->search.mip_level, "of the texture")->capture_default_str();
  command->footer(
      "Example:\n  wheatstone quality refresh --texture "
      "../shared/reference/perception/sample_frame/"
      "scene_snapshot.png --budget 0.25 --output out/refresh.csv");
  command->callback([=] { write_refresh_table(*o); });
}

}  // namespace wheatstone::apps
