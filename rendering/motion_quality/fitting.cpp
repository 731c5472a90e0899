#include "rendering/motion_quality/fitting.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.h"

namespace wheatstone {
namespace {

/// Least-squares scale and, if affine, offset from model values to scores, for some measurements.
struct Line {
  double scale = 0, offset = 0;
};
Line fitted_line(const QualityExperiments& data, const std::vector<std::size_t>& members,
                 const std::vector<double>& values, bool affine) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const std::size_t i : members) {
    n += 1;
    x += values[i];
    y += data.measurements[i].score;
    xx += values[i] * values[i];
    xy += values[i] * data.measurements[i].score;
  }
  if (!affine) return {xx > 0 ? xy / xx : 0, 0};
  const double spread = n * xx - x * x, scale = spread > 0 ? (n * xy - x * y) / spread : 0;
  return {scale, n > 0 ? (y - scale * x) / n : 0};
}

/// Replaces values by scale * value + offset, one fit for each group of experiments.
void scale_to_scores(const QualityExperiments& data,
                     const std::vector<std::vector<Experiment>>& groups, bool affine,
                     std::vector<double>& values) {
  for (const auto& group : groups) {
    std::vector<std::size_t> members;
    for (const Experiment e : group)
      for (const std::size_t i : data.of(e)) members.push_back(i);
    const Line line = fitted_line(data, members, values, affine);
    for (const std::size_t i : members) values[i] = line.scale * values[i] + line.offset;
  }
}

const std::vector<std::vector<Experiment>> kExternal = {
    {Experiment::kMackin2016}, {Experiment::kItuFps}, {Experiment::kItuPpd}};

ExperimentPredictions judged(const QualityExperiments& data, std::vector<double> scores) {
  std::array<double, kExperiments> squares{}, count{};
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const QualityMeasurement& m = data.measurements[i];
    const auto e = static_cast<std::size_t>(m.experiment);
    squares[e] += (scores[i] - m.score) * (scores[i] - m.score);
    count[e] += 1;
  }
  ExperimentPredictions out;
  out.scores = std::move(scores);
  double pooled = 0, pooled_count = 0;
  for (std::size_t e = 0; e < kExperiments; ++e) {
    out.rmse[e] = std::sqrt(squares[e] / count[e]);
    if (!calibrates(static_cast<Experiment>(e))) continue;
    pooled += squares[e];
    pooled_count += count[e];
  }
  out.pooled_rmse_jnd = std::sqrt(pooled / pooled_count);
  return out;
}

/// Ds and Dt of every measurement for any beta; each beta costs a run of the whole model, once.
class DistortionsByBeta {
 public:
  DistortionsByBeta(const QualityExperiments& data, const CamojabModel& model)
      : data_(data), model_(model) {}
  const std::vector<CamojabQuality>& at(double beta) {
    const auto known = known_.find(beta);
    if (known != known_.end()) return known->second;
    model_.weights.beta = beta;
    return known_.emplace(beta, distortions(data_, model_)).first->second;
  }

 private:
  const QualityExperiments& data_;
  CamojabModel model_;
  std::map<double, std::vector<CamojabQuality>> known_;
};

/// Residuals (predicted - measured, JND) of all measurements that calibrate. Parameters:
/// {ws, wt, a2, a3} and {beta}; a1 is fixed. Derivatives by beta are central differences.
class CalibrationResiduals : public ceres::CostFunction {
 public:
  CalibrationResiduals(const QualityExperiments& data, DistortionsByBeta& distortions, double a1)
      : data_(data), distortions_(distortions), a1_(a1) {
    for (std::size_t i = 0; i < data.measurements.size(); ++i)
      if (calibrates(data.measurements[i].experiment)) members_.push_back(i);
    set_num_residuals(static_cast<int>(members_.size()));
    *mutable_parameter_block_sizes() = {4, 1};
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const double* p = parameters[0];
    const double beta = parameters[1][0];
    const double step = 1e-4 * beta;
    if (!(beta > step && beta + step <= kCamojabMaxBeta)) return false;  // refuse the step
    const auto& d = distortions_.at(beta);
    for (std::size_t r = 0; r < members_.size(); ++r)
      residuals[r] = predicted(p, d, members_[r]) - data_.measurements[members_[r]].score;
    if (jacobians && jacobians[0])
      for (std::size_t r = 0; r < members_.size(); ++r)
        differentiate(p, d, members_[r], jacobians[0] + 4 * r);
    if (jacobians && jacobians[1]) {
      const auto &above = distortions_.at(beta + step), &below = distortions_.at(beta - step);
      for (std::size_t r = 0; r < members_.size(); ++r)
        jacobians[1][r] =
            (predicted(p, above, members_[r]) - predicted(p, below, members_[r])) / (2 * step);
    }
    return true;
  }

 private:
  using Distortions = std::vector<CamojabQuality>;

  /// d Ds and d Dt of measurement i from its baseline.
  std::pair<double, double> differences(const Distortions& d, std::size_t i) const {
    const CamojabQuality& base = d[data_.measurements[i].baseline];
    return {d[i].spatial_distortion - base.spatial_distortion,
            d[i].temporal_distortion - base.temporal_distortion};
  }

  double predicted(const double* p, const Distortions& d, std::size_t i) const {
    const auto [spatial, temporal] = differences(d, i);
    const Experiment e = data_.measurements[i].experiment;
    if (e == Experiment::kJudder) return p[3] * temporal;
    return (e == Experiment::kRefreshRate ? p[2] : a1_) * (p[0] * spatial + p[1] * temporal);
  }

  /// d predicted / d {ws, wt, a2, a3}.
  void differentiate(const double* p, const Distortions& d, std::size_t i, double* out) const {
    const auto [spatial, temporal] = differences(d, i);
    const Experiment e = data_.measurements[i].experiment;
    const bool refresh = e == Experiment::kRefreshRate, judder = e == Experiment::kJudder;
    const double multiplier = judder ? 0 : refresh ? p[2] : a1_;
    out[0] = multiplier * spatial;
    out[1] = multiplier * temporal;
    out[2] = refresh ? p[0] * spatial + p[1] * temporal : 0;
    out[3] = judder ? temporal : 0;
  }

  const QualityExperiments& data_;
  DistortionsByBeta& distortions_;
  double a1_;
  std::vector<std::size_t> members_;
};

CamojabFit fit(const QualityExperiments& data, DistortionsByBeta& distortions,
               const CamojabWeights& start, bool fit_beta) {
  CamojabFit fit;
  double linear[4] = {start.spatial, start.temporal, fit.multipliers.refresh_rate,
                      fit.multipliers.judder};
  double beta = start.beta;
  ceres::Problem problem;
  problem.AddResidualBlock(
      new CalibrationResiduals(data, distortions, fit.multipliers.shading_rate), nullptr, linear,
      &beta);
  if (!fit_beta) problem.SetParameterBlockConstant(&beta);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = 1e-12;
  options.max_num_iterations = 100;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  fit.weights = {linear[0], linear[1], beta};
  fit.multipliers.refresh_rate = linear[2];
  fit.multipliers.judder = linear[3];
  fit.predictions = camojab_predictions(data, distortions.at(beta), fit.weights, fit.multipliers);
  fit.converged = summary.termination_type == ceres::CONVERGENCE;
  fit.report = summary.BriefReport();
  return fit;
}

}  // namespace

std::vector<CamojabQuality> distortions(const QualityExperiments& data, const CamojabModel& model) {
  std::map<std::string, std::vector<std::size_t>> by_texture;
  for (std::size_t i = 0; i < data.measurements.size(); ++i)
    by_texture[data.measurements[i].texture].push_back(i);
  std::vector<CamojabQuality> out(data.measurements.size());
  for (const auto& [name, members] : by_texture) {
    const auto texture = data.textures.find(name);
    if (texture == data.textures.end())
      throw ArgumentError("texture '" + name + "' of the measurements is missing", "add it");
    std::vector<CamojabConditions> conditions;
    for (const std::size_t i : members) conditions.push_back(data.measurements[i].conditions);
    const std::vector<CamojabQuality> results =
        Camojab(texture->second, model).evaluate(conditions);
    for (std::size_t k = 0; k < members.size(); ++k) out[members[k]] = results[k];
  }
  return out;
}

ExperimentPredictions camojab_predictions(const QualityExperiments& data,
                                          const std::vector<CamojabQuality>& distortions,
                                          const CamojabWeights& weights,
                                          const CamojabMultipliers& multipliers) {
  WHEATSTONE_CHECK(distortions.size(), ==, data.measurements.size());
  const auto quality = [&](std::size_t i) {
    return weights.spatial * distortions[i].spatial_distortion +
           weights.temporal * distortions[i].temporal_distortion;
  };
  std::vector<double> scores(data.measurements.size());
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const QualityMeasurement& m = data.measurements[i];
    const double better = quality(i) - quality(m.baseline);
    if (!calibrates(m.experiment))
      scores[i] = quality(i);
    else if (m.experiment == Experiment::kRefreshRate)
      scores[i] = multipliers.refresh_rate * better;
    else if (m.experiment == Experiment::kJudder)
      scores[i] = multipliers.judder * (distortions[i].temporal_distortion -
                                        distortions[m.baseline].temporal_distortion);
    else
      scores[i] = multipliers.shading_rate * better;
  }
  scale_to_scores(data, kExternal, true, scores);
  return judged(data, std::move(scores));
}

ExperimentPredictions camojab_predictions(const QualityExperiments& data, const CamojabModel& model,
                                          const CamojabMultipliers& multipliers) {
  return camojab_predictions(data, distortions(data, model), model.weights, multipliers);
}

ExperimentPredictions marrr_predictions(const QualityExperiments& data,
                                        MotionQualityPreset preset) {
  const Marrr model(preset, Motion::kPredictable);
  const auto display = [](const CamojabConditions& c) {
    return MarrrDisplay{c.refresh_hz, c.ppd * c.shading_rate_x, c.persistence};
  };
  std::vector<double> scores(data.measurements.size());
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const QualityMeasurement& m = data.measurements[i];
    const CamojabConditions &c = m.conditions, &base = data.measurements[m.baseline].conditions;
    scores[i] = m.experiment == Experiment::kJudder
                    ? model.judder_energy(c.refresh_hz, c.speed_deg_per_s) -
                          model.judder_energy(base.refresh_hz, c.speed_deg_per_s)
                    : model.quality_difference_jnd(display(c), display(base), c.speed_deg_per_s);
  }
  scale_to_scores(data,
                  {{Experiment::kVrsPc, Experiment::kVrsMobile, Experiment::kVrsVr},
                   {Experiment::kRefreshRate},
                   {Experiment::kJudder}},
                  false, scores);
  scale_to_scores(data, kExternal, true, scores);
  return judged(data, std::move(scores));
}

CamojabFit fit_camojab(const QualityExperiments& data, const CamojabModel& start, bool fit_beta) {
  DistortionsByBeta distortions(data, start);
  return fit(data, distortions, start.weights, fit_beta);
}

std::vector<CamojabVariant> camojab_variants() {
  std::vector<CamojabVariant> out;
  const auto add = [&](const char* change, auto apply) {
    out.push_back({change, CamojabModel{}});
    apply(out.back().model);
  };
  using Model = CamojabModel;
  add("released", [](Model&) {});
  add("no mip blur", [](Model& m) { m.mip_blur = false; });
  add("no aliasing", [](Model& m) { m.aliasing = false; });
  add("no clipping", [](Model& m) { m.clipping = false; });
  add("no aliasing, no clipping", [](Model& m) { m.aliasing = m.clipping = false; });
  add("no judder", [](Model& m) { m.judder = false; });
  add("no hold blur", [](Model& m) { m.hold_blur = false; });
  add("no eye blur", [](Model& m) { m.eye_blur = false; });
  add("no motion blur", [](Model& m) { m.hold_blur = m.eye_blur = false; });
  add("Euclidean radius", [](Model& m) { m.radius = Model::Radius::kEuclidean; });
  add("comb at full interval, one side",
      [](Model& m) { m.comb = Model::Comb::kFullIntervalOneSide; });
  add("comb at full interval, two sides",
      [](Model& m) { m.comb = Model::Comb::kFullIntervalTwoSides; });
  add("alias at omega/v", [](Model& m) { m.alias_position = 1; });
  add("published", [](Model& m) { m = Model::preset(MotionQualityPreset::kPublished); });
  return out;
}

AblationRow ablate(const QualityExperiments& data, const CamojabVariant& variant, bool fit_beta) {
  DistortionsByBeta distortions(data, variant.model);
  const CamojabWeights& released = variant.model.weights;
  return {variant.change, camojab_predictions(data, distortions.at(released.beta), released, {}),
          fit(data, distortions, released, fit_beta)};
}

}  // namespace wheatstone
