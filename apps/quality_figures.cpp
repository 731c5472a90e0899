#include "apps/quality_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "rendering/motion_quality/fitting.h"

namespace wheatstone::apps {
namespace {

/// Measurements and predictions of one line of a panel.
struct Curve {
  std::vector<double> x, measured, low, high, predicted;
};

/// Adds the chosen measurements to a panel, one curve for each speed; `x_of` gives the abscissa.
template <class Chosen, class XOf>
void add_curves(Plot& plot, const QualityExperiments& data, const std::vector<double>& predicted,
                Chosen chosen, XOf x_of) {
  std::map<double, Curve> by_speed;
  for (std::size_t i = 0; i < data.measurements.size(); ++i) {
    const QualityMeasurement& m = data.measurements[i];
    if (!chosen(m)) continue;
    Curve& c = by_speed[m.conditions.speed_deg_per_s];
    c.x.push_back(x_of(m.conditions));
    c.measured.push_back(m.score);
    c.low.push_back(m.score_low);
    c.high.push_back(m.score_high);
    c.predicted.push_back(predicted[i]);
  }
  for (const auto& [speed, c] : by_speed) {
    const std::string name = fmt::format("{:g} deg/s", speed);
    plot.line(name, c.x, c.predicted);
    plot.points(name, c.x, c.measured, c.low, c.high);
  }
}

ExperimentPredictions predictions(const QualityExperiments& data, MotionQualityPreset preset) {
  const CamojabModel model = CamojabModel::preset(preset);
  // The released multipliers belong to the released preset; the other needs its own.
  return preset == MotionQualityPreset::kReleased ? camojab_predictions(data, model)
                                                  : fit_camojab(data, model, false).predictions;
}

double refresh_of(const CamojabConditions& c) {
  return c.refresh_hz;
}
double rate_of(const CamojabConditions& c) {
  return c.shading_rate_x;
}

}  // namespace

std::vector<Plot> marrr_optimum_figure(MotionQualityPreset preset) {
  const std::vector<std::pair<std::string, double>> budgets = {
      {"1/6 of the pixels", 1.0 / 6}, {"1/4", 0.25}, {"1/3", 1.0 / 3}, {"1/2", 0.5}};
  std::vector<double> speeds, fractions;
  for (int v = 0; v <= 50; ++v) speeds.push_back(v);
  for (const auto& [name, fraction] : budgets) fractions.push_back(fraction);
  std::vector<Plot> panels;
  for (const Motion motion : {Motion::kPredictable, Motion::kUnpredictable}) {
    const MarrrTable table(Marrr(preset, motion), speeds, fractions);
    const std::string kind =
        motion == Motion::kPredictable ? "predictable motion" : "unpredictable motion";
    Plot refresh("MARRR, " + kind, {"speed (deg/s)"},
                 {"best refresh rate (Hz)", false, std::pair{40.0, 180.0}}),
        resolution("MARRR, " + kind, {"speed (deg/s)"},
                   {"resolution left (of width and height)", false, std::pair{0.0, 1.05}});
    for (std::size_t f = 0; f < budgets.size(); ++f) {
      std::vector<double> hz, left;
      for (std::size_t s = 0; s < speeds.size(); ++s) {
        hz.push_back(table.at(s, f).refresh_hz);
        left.push_back(table.at(s, f).resolution_reduction);
      }
      refresh.line(budgets[f].first, speeds, hz);
      resolution.line(budgets[f].first, speeds, left);
    }
    panels.push_back(std::move(refresh));
    panels.push_back(std::move(resolution));
  }
  return panels;
}

std::vector<Plot> shading_rate_figure(const QualityExperiments& data, MotionQualityPreset preset) {
  const ExperimentPredictions p = predictions(data, preset);
  std::vector<Plot> panels;
  for (const Experiment block : {Experiment::kVrsPc, Experiment::kVrsMobile, Experiment::kVrsVr}) {
    std::map<std::string, bool> textures;
    for (const std::size_t i : data.of(block)) textures[data.measurements[i].texture] = true;
    for (const auto& [texture, present] : textures) {
      Plot plot(fmt::format("{}, {}", kExperimentNames[static_cast<std::size_t>(block)], texture),
                {"horizontal shading rate", true, std::pair{0.22, 1.15}, {0.25, 0.5, 1}},
                {"quality against full rate (JND)"});
      add_curves(
          plot, data, p.scores,
          [&](const QualityMeasurement& m) {
            return m.experiment == block && m.texture == texture;
          },
          rate_of);
      panels.push_back(std::move(plot));
    }
  }
  return panels;
}

std::vector<Plot> refresh_rate_figure(const QualityExperiments& data, MotionQualityPreset preset) {
  const ExperimentPredictions p = predictions(data, preset);
  struct Panel {
    Experiment experiment;
    const char* title;
    PlotAxis x, y;
    double (*x_of)(const CamojabConditions&);
  };
  const PlotAxis refresh{"refresh rate (Hz)"};
  const auto logarithmic = [](const char* label, const std::vector<double>& ticks) {
    return PlotAxis{label, true, {}, ticks};
  };
  const std::vector<Panel> all = {
      {Experiment::kRefreshRate,
       "Experiment 1",
       refresh,
       {"quality against 50 Hz (JND)"},
       refresh_of},
      {Experiment::kJudder,
       "Experiment 3: judder alone",
       refresh,
       {"judder against 82.5 Hz (JND)"},
       refresh_of},
      {Experiment::kMackin2016,
       "Mackin et al. 2016",
       logarithmic("refresh rate (Hz)", {60, 100, 200, 500, 1000, 2000}),
       {"mean opinion score (1 to 5)"},
       refresh_of},
      {Experiment::kItuFps,
       "ITU-R, refresh rate",
       logarithmic("refresh rate (Hz)", {30, 60, 120, 240}),
       {"score"},
       refresh_of},
      {Experiment::kItuPpd,
       "ITU-R, resolution",
       logarithmic("horizontal resolution (of 59 ppd)", {0.25, 0.5, 1}),
       {"score"},
       rate_of}};
  std::vector<Plot> panels;
  for (const Panel& panel : all) {
    Plot plot(panel.title, panel.x, panel.y);
    add_curves(
        plot, data, p.scores,
        [&](const QualityMeasurement& m) { return m.experiment == panel.experiment; }, panel.x_of);
    panels.push_back(std::move(plot));
  }
  return panels;
}

std::vector<Plot> refresh_table_figure(const RefreshTable& table) {
  Plot best("Best refresh rate", {"speed (deg/s)"}, {"refresh rate (Hz)"});
  std::map<double, Curve> by_budget;
  for (const RefreshEntry& e : table.entries()) {
    by_budget[e.budget_fraction].x.push_back(e.speed_deg_per_s);
    by_budget[e.budget_fraction].predicted.push_back(e.best_refresh_hz);
  }
  for (const auto& [fraction, c] : by_budget) {
    const std::string name = fmt::format("{:g} % of full rate", 100 * fraction);
    best.line(name, c.x, c.predicted);
    best.points(name, c.x, c.predicted);
  }

  const double smallest = by_budget.begin()->first;
  Plot quality(fmt::format("Quality at {:g} % of full rate", 100 * smallest), {"refresh rate (Hz)"},
               {"quality below the best rate's (model units)"});
  std::map<double, Curve> by_speed;
  for (const RefreshCandidate& c : table.candidates()) {
    if (c.budget_fraction != smallest || c.resolution_reduction > 1.001) continue;
    Curve& curve = by_speed[c.speed_deg_per_s];
    curve.x.push_back(c.refresh_hz);
    curve.predicted.push_back(c.quality);
  }
  for (auto& [speed, c] : by_speed) {
    const double best_quality = *std::max_element(c.predicted.begin(), c.predicted.end());
    for (double& q : c.predicted) q -= best_quality;
    quality.line(fmt::format("{:g} deg/s", speed), c.x, c.predicted);
  }
  return {best, quality};
}

}  // namespace wheatstone::apps
