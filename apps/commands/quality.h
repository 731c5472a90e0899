#pragma once
// The subcommands of `wheatstone quality`; each function adds its own.

#include <CLI/App.hpp>

namespace wheatstone::apps {

void add_quality_allocate(CLI::App& quality);
void add_quality_camojab(CLI::App& quality);
void add_quality_csf(CLI::App& quality);
void add_quality_map(CLI::App& quality);
void add_quality_marrr(CLI::App& quality);  // marrr and marrr-optimum
void add_quality_plot(CLI::App& quality);
void add_quality_polynomials(CLI::App& quality);
void add_quality_refresh(CLI::App& quality);
void add_quality_tables(CLI::App& quality);  // table-5-3, ablation and fit

}  // namespace wheatstone::apps
