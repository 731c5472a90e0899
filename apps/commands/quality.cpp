#include "apps/commands/quality.h"

#include <CLI/CLI.hpp>

#include "apps/commands/commands.h"

namespace wheatstone::apps {

void add_quality(CLI::App& app) {
  auto* quality = app.add_subcommand("quality",
                                     "Models of motion quality: what refresh rate, "
                                     "resolution and shading cost the viewer");
  quality->require_subcommand(1);
  quality->footer("Example:\n  wheatstone quality plot 3.4 --output out/best_refresh_rate.svg");
  for (const auto add : {add_quality_csf, add_quality_marrr, add_quality_camojab,
                         add_quality_tables, add_quality_plot, add_quality_refresh,
                         add_quality_polynomials, add_quality_allocate, add_quality_map})
    add(*quality);
}

}  // namespace wheatstone::apps
