#include <CLI/CLI.hpp>
#include <map>
#include <memory>

#include "apps/commands/quality.h"
#include "apps/commands/quality_options.h"
#include "core/error.h"
#include "rendering/motion_quality/contrast_sensitivity.h"

namespace wheatstone::apps {
namespace {

/// Sensitivity from the columns of one row.
using Csf = double (*)(const CsvTable&, std::size_t row);

const std::map<std::string, Csf>& models() {
  static const std::map<std::string, Csf> kModels = {
      {"barten",
       [](const CsvTable& t, std::size_t row) {
         return barten_csf(t.finite_number(row, "u_cpd"), t.finite_number(row, "L_cd_m2"),
                           t.finite_number(row, "X0_deg"));
       }},
      {"kelly",
       [](const CsvTable& t, std::size_t row) {
         return kelly_csf(t.finite_number(row, "rho_cpd"), t.finite_number(row, "omega_hz"));
       }},
      {"velocity",
       [](const CsvTable& t, std::size_t row) {
         return velocity_csf(t.finite_number(row, "rho_cpd"),
                             t.finite_number(row, "velocity_deg_s"));
       }},
      {"static",
       [](const CsvTable& t, std::size_t row) {
         return static_csf(t.finite_number(row, "rho_cpd"), t.finite_number(row, "L_cd_m2"));
       }},
      {"spatiotemporal",
       [](const CsvTable& t, std::size_t row) {
         return spatiotemporal_csf(t.finite_number(row, "rho_cpd"),
                                   t.finite_number(row, "omega_hz"),
                                   t.finite_number(row, "L_cd_m2"));
       }},
  };
  return kModels;
}

}  // namespace

void add_quality_csf(CLI::App& quality) {
  auto* command = quality.add_subcommand("csf", "Contrast sensitivity S of the models");
  auto model = std::make_shared<std::string>();
  auto table = std::make_shared<TableOptions>();
  command
      ->add_option("--model", *model,
                   "barten (columns u_cpd, L_cd_m2, X0_deg), kelly (rho_cpd, omega_hz), velocity "
                   "(rho_cpd, velocity_deg_s), static (rho_cpd, L_cd_m2) or spatiotemporal "
                   "(rho_cpd, omega_hz, L_cd_m2)")
      ->required();
  table->add_to(*command);
  command->footer(
      "Example:\n  wheatstone quality csf --model barten --input ../shared/reference/perception/"
      "vectors/csf_barten.csv --output out/csf.csv");
  command->callback([=] {
    const auto csf = models().find(*model);
    if (csf == models().end())
      throw ArgumentError("'" + *model + "' is no model of contrast sensitivity",
                          "use barten, kelly, velocity, static or spatiotemporal");
    CsvTable t = CsvTable::read(table->input);
    std::vector<double> s(t.rows());
    for_each_row(t, [&](std::size_t row) { s[row] = csf->second(t, row); });
    t.set_column("S", s);
    table->finish(t);
  });
}

}  // namespace wheatstone::apps
