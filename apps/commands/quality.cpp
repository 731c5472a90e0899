#include "apps/commands/quality.h"

#include <CLI/CLI.hpp>

#include "apps/commands/commands.h"

namespace wheatstone::apps {

void add_quality(CLI::App& app) {
  auto* quality = app.add_subcommand("quality", "Quality of motion: models and what follows");
  quality->require_subcommand(1);
  for (const auto add :
       {add_quality_refresh, add_quality_polynomials, add_quality_allocate, add_quality_map})
    add(*quality);
}

}  // namespace wheatstone::apps
