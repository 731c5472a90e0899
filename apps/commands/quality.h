#pragma once
// The subcommands of `wheatstone quality`, one file each; each function adds its own.

#include <CLI/App.hpp>

namespace wheatstone::apps {

void add_quality_allocate(CLI::App& quality);
void add_quality_map(CLI::App& quality);
void add_quality_polynomials(CLI::App& quality);
void add_quality_refresh(CLI::App& quality);

}  // namespace wheatstone::apps
