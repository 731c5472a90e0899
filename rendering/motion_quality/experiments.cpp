#include "rendering/motion_quality/experiments.h"

#include <fmt/format.h>

#include <cmath>

#include "core/csv.h"
#include "core/error.h"
#include "rendering/motion_quality/grey_texture.h"

namespace wheatstone {
namespace {

/// What all of MARRR's experiments showed, at 2560 px over 30 deg.
CamojabConditions marrr_conditions(double refresh_hz, double speed_deg_per_s) {
  return {2560 / 30.0, refresh_hz, speed_deg_per_s, 1, 100, 1, 1, 1};
}
constexpr const char* kMarrrTexture = "marrr_checkerboard";

using NamedExperiments = std::vector<std::pair<std::string, Experiment>>;

/// The experiment that a cell names; FileError otherwise.
Experiment experiment_in(const CsvTable& t, std::size_t row, const std::string& column,
                         const NamedExperiments& named) {
  std::string known;
  for (const auto& [name, experiment] : named) {
    if (t.text(row, column) == name) return experiment;
    known += (known.empty() ? "" : ", ") + name;
  }
  throw FileError(t.where(row), fmt::format("{} '{}' is unknown", column, t.text(row, column)),
                  "use one of " + known);
}

void read_vrs(const std::filesystem::path& file, std::vector<QualityMeasurement>& out) {
  const NamedExperiments blocks = {
      {"PC", Experiment::kVrsPc}, {"Mobile", Experiment::kVrsMobile}, {"VR", Experiment::kVrsVr}};
  const CsvTable t = CsvTable::read(file);
  for (std::size_t i = 0; i < t.rows(); ++i) {
    const auto value = [&](const char* column) { return t.finite_number(i, column); };
    const CamojabConditions conditions{value("ppd_used_in_model"),
                                       value("refresh_hz"),
                                       std::abs(value("velocity_deg_s") - 2),
                                       value("persistence"),
                                       value("mean_lum_cd_m2"),
                                       value("mip_level"),
                                       value("shading_resolution_x"),
                                       1};
    const double jnd = value("jnd");
    out.push_back({experiment_in(t, i, "block", blocks), t.text(i, "texture"), conditions, jnd,
                   jnd - value("ci_low_halfwidth"), jnd + value("ci_high_halfwidth")});
  }
}

void read_refresh_rates(const std::filesystem::path& file, std::vector<QualityMeasurement>& out) {
  const CsvTable t = CsvTable::read(file);
  for (std::size_t i = 0; i < t.rows(); ++i) {
    if (!t.text(i, "condition").starts_with("predictable")) continue;
    const auto value = [&](const char* column) { return t.finite_number(i, column); };
    const double jnd = value("jnd_zeroed_at_50hz");
    out.push_back({Experiment::kRefreshRate, kMarrrTexture,
                   marrr_conditions(value("refresh_hz"), value("velocity_deg_s")), jnd,
                   jnd - value("ci75_low_halfwidth"), jnd + value("ci75_high_halfwidth")});
  }
}

void read_judder(const std::filesystem::path& file, std::vector<QualityMeasurement>& out) {
  constexpr double kSpeed_deg_per_s = 25;
  const CsvTable t = CsvTable::read(file);
  for (std::size_t i = 0; i < t.rows(); ++i) {
    const double jnd = t.finite_number(i, "jnd_predictable");
    out.push_back({Experiment::kJudder, kMarrrTexture,
                   marrr_conditions(t.finite_number(i, "refresh_hz"), kSpeed_deg_per_s), jnd, jnd,
                   jnd});
  }
}

void read_external(const std::filesystem::path& file, std::vector<QualityMeasurement>& out) {
  const NamedExperiments sets = {{"mackin2016", Experiment::kMackin2016},
                                 {"itu_fps", Experiment::kItuFps},
                                 {"itu_ppd", Experiment::kItuPpd}};
  const CsvTable t = CsvTable::read(file);
  for (std::size_t i = 0; i < t.rows(); ++i) {
    const auto value = [&](const char* column) { return t.finite_number(i, column); };
    const CamojabConditions conditions{value("ppd"),
                                       value("refresh_hz"),
                                       value("velocity_deg_s"),
                                       value("persistence"),
                                       value("mean_lum_cd_m2"),
                                       value("mip_level"),
                                       value("srx"),
                                       1};
    out.push_back({experiment_in(t, i, "dataset", sets), "checkerboard", conditions, value("score"),
                   value("score_low"), value("score_high")});
  }
}

/// Whether `b` may be the zero that `a` is compared with.
bool is_baseline_of(const QualityMeasurement& b, const QualityMeasurement& a) {
  if (a.experiment != b.experiment || a.texture != b.texture ||
      a.conditions.speed_deg_per_s != b.conditions.speed_deg_per_s)
    return false;
  switch (a.experiment) {
    case Experiment::kRefreshRate:
      return b.conditions.refresh_hz == 50;
    case Experiment::kJudder:
      return b.conditions.refresh_hz == 82.5;
    case Experiment::kMackin2016:
      return b.conditions.refresh_hz == 2000;
    case Experiment::kItuFps:
      return b.conditions.refresh_hz == 240;
    default:
      return b.conditions.shading_rate_x == 1;
  }
}

}  // namespace

std::vector<std::size_t> QualityExperiments::of(Experiment experiment) const {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < measurements.size(); ++i)
    if (measurements[i].experiment == experiment) out.push_back(i);
  return out;
}

QualityExperiments read_quality_experiments(const std::filesystem::path& data,
                                            const std::filesystem::path& textures) {
  QualityExperiments all;
  std::vector<QualityMeasurement>& m = all.measurements;
  const std::pair<const char*,
                  void (*)(const std::filesystem::path&, std::vector<QualityMeasurement>&)>
      files[] = {{"vrs_experiment_jnd.csv", read_vrs},
                 {"marrr_experiment1_jnd.csv", read_refresh_rates},
                 {"marrr_experiment3.csv", read_judder},
                 {"external_validation.csv", read_external}};
  for (const auto& [name, read] : files) {
    const std::filesystem::path file = data / name;
    const std::size_t first = m.size();
    read(file, m);
    for (std::size_t i = first; i < m.size(); ++i) {
      m[i].baseline = first;
      while (m[i].baseline < m.size() && !is_baseline_of(m[m[i].baseline], m[i])) ++m[i].baseline;
      if (m[i].baseline == m.size())
        throw FileError(file,
                        fmt::format("{} at {} deg/s has no row to compare with",
                                    kExperimentNames[static_cast<std::size_t>(m[i].experiment)],
                                    m[i].conditions.speed_deg_per_s),
                        "use the published table with all of its rows");
    }
  }
  for (const QualityMeasurement& one : m)
    if (!all.textures.contains(one.texture))
      all.textures.emplace(one.texture,
                           CamojabTexture(read_grey_texture(textures / (one.texture + ".exr"))));
  return all;
}

}  // namespace wheatstone
