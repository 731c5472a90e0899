#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/commands/common.h"
#include "apps/commands/quality.h"
#include "apps/commands/quality_options.h"
#include "core/error.h"
#include "rendering/motion_quality/fitting.h"

namespace wheatstone::apps {
namespace {

// As the thesis prints them, in the order of kExperimentNames.
constexpr std::array<double, kExperiments> kThesisCamojab = {0.74, 0.57, 0.53, 0.38,
                                                             0.03, 0.42, 0.28, 0.69},
                                           kThesisMarrr = {1.82, 1.55, 1.14, 0.55,
                                                           0.04, 0.55, 0.15, 0.25};

void print_header(const std::string& corner) {
  fmt::print("{:<34}", corner);
  for (const char* name : kExperimentNames) fmt::print("{:>9}", name);
  fmt::print("\n");
}

void print_row(const std::string& name, const std::array<double, kExperiments>& rmse,
               int decimals) {
  fmt::print("{:<34}", name);
  for (const double v : rmse) fmt::print("{:>9.{}f}", v, decimals);
  fmt::print("\n");
}

nlohmann::json json_of(const std::array<double, kExperiments>& rmse) {
  nlohmann::json out;
  for (std::size_t e = 0; e < kExperiments; ++e) out[kExperimentNames[e]] = rmse[e];
  return out;
}

nlohmann::json json_of(const CamojabFit& fit) {
  return {{"ws", fit.weights.spatial},
          {"wt", fit.weights.temporal},
          {"beta", fit.weights.beta},
          {"a1", fit.multipliers.shading_rate},
          {"a2", fit.multipliers.refresh_rate},
          {"a3", fit.multipliers.judder},
          {"rmse", json_of(fit.predictions.rmse)},
          {"pooled_rmse_jnd", fit.predictions.pooled_rmse_jnd},
          {"converged", fit.converged}};
}

void table_5_3(const ExperimentOptions& options, bool json) {
  const QualityExperiments data = options.read();
  const ExperimentPredictions camojab = camojab_predictions(data), marrr = marrr_predictions(data);
  const char* note =
      "MARRR on ITU ppd cannot be reproduced: the thesis gives 0.25 but not its settings.";
  if (json) {
    const nlohmann::json out = {{"camojab", json_of(camojab.rmse)},
                                {"camojab_thesis", json_of(kThesisCamojab)},
                                {"camojab_pooled_rmse_jnd", camojab.pooled_rmse_jnd},
                                {"marrr", json_of(marrr.rmse)},
                                {"marrr_thesis", json_of(kThesisMarrr)},
                                {"note", note}};
    fmt::print("{}\n", out.dump(1));
    return;
  }
  print_header("RMSE");
  print_row("CaMoJAB, thesis", kThesisCamojab, 2);
  print_row("CaMoJAB, obtained", camojab.rmse, 4);
  print_row("MARRR, thesis", kThesisMarrr, 2);
  print_row("MARRR, obtained", marrr.rmse, 4);
  fmt::print(
      "PC to Exp. 3 in JND, Mackin and ITU in their own scores.\n"
      "CaMoJAB over all {} measurements in JND: {:.4f}.\n"
      "{} Obtained here: {:.3f}.\n",
      std::count_if(data.measurements.begin(), data.measurements.end(),
                    [](const QualityMeasurement& m) { return calibrates(m.experiment); }),
      camojab.pooled_rmse_jnd, note, marrr.rmse[static_cast<std::size_t>(Experiment::kItuPpd)]);
}

void ablation(const ExperimentOptions& options, bool fit_beta, bool json) {
  const QualityExperiments data = options.read();
  const std::vector<CamojabVariant> variants = camojab_variants();
  nlohmann::json out = nlohmann::json::array();
  if (!json) print_header("RMSE");
  for (std::size_t i = 0; i < variants.size(); ++i) {
    const AblationRow row = ablate(data, variants[i], fit_beta);
    if (json) {
      out.push_back({{"change", row.change},
                     {"kept", json_of(row.kept.rmse)},
                     {"refitted", json_of(row.refitted)}});
    } else {
      print_row(row.change, row.kept.rmse, 3);
      print_row("  refitted", row.refitted.predictions.rmse, 3);
    }
    show_progress("ablation", static_cast<int>(i + 1), static_cast<int>(variants.size()));
  }
  if (json) fmt::print("{}\n", out.dump(1));
}

void fit(const ExperimentOptions& options, MotionQualityPreset preset, bool keep_beta, bool json) {
  const CamojabFit fit = fit_camojab(options.read(), CamojabModel::preset(preset), !keep_beta);
  if (!fit.converged)
    throw ArgumentError("the fit did not converge (" + fit.report + ")",
                        "check the measurements, or keep beta with --keep-beta");
  if (json) {
    fmt::print("{}\n", json_of(fit).dump(1));
    return;
  }
  fmt::print("ws {:.6f}  wt {:.6f}  beta {:.6f}\na1 {:.6f} (kept)  a2 {:.6f}  a3 {:.6f}\n",
             fit.weights.spatial, fit.weights.temporal, fit.weights.beta,
             fit.multipliers.shading_rate, fit.multipliers.refresh_rate, fit.multipliers.judder);
  print_header("RMSE");
  print_row("refitted", fit.predictions.rmse, 4);
}

}  // namespace

void add_quality_tables(CLI::App& quality) {
  auto options = std::make_shared<ExperimentOptions>();
  auto json = std::make_shared<bool>(false);
  auto flag = std::make_shared<bool>(false);
  auto preset = std::make_shared<std::string>("released");
  const auto add = [&](const char* name, const char* description) {
    auto* command = quality.add_subcommand(name, description);
    options->add_to(*command);
    command->add_flag("--json", *json, "the result as JSON on standard output");
    command->footer(fmt::format(
        "Example:\n  wheatstone quality {} --data ../shared/reference/perception/data --textures "
        "../shared/reference/perception/textures",
        name));
    return command;
  };

  auto* table = add("table-5-3", "How far MARRR and CaMoJAB are from the published measurements");
  table->callback([=] { table_5_3(*options, *json); });

  auto* ablate = add("ablation", "The same for CaMoJAB with stages left out or changed");
  ablate->add_flag("--fit-beta", *flag, "refit beta too (slow)");
  ablate->callback([=] { ablation(*options, *flag, *json); });

  auto* refit = add("fit", "CaMoJAB's weights, exponent and multipliers refitted");
  refit->add_flag("--keep-beta", *flag, "keep the exponent");
  add_preset_option(*refit, *preset);
  refit->callback([=] { fit(*options, motion_quality_preset_from_string(*preset), *flag, *json); });
}

}  // namespace wheatstone::apps
