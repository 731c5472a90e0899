#pragma once
// How well MARRR and CaMoJAB explain the measurements, and CaMoJAB's weights refitted to them.
// Source: thesis (UCAM-CL-TR-977), section 5.4, tables 5.2 to 5.4.

#include <optional>
#include <string>
#include <vector>

#include "rendering/motion_quality/experiments.h"
#include "rendering/motion_quality/marrr.h"

namespace wheatstone {

/// Factors from model units to the JND of an experiment, as released: of Q for the first two, of
/// Dt alone for the third.
struct CamojabMultipliers {
  double shading_rate = 0.664885783739141;  // a1, the VRS experiment
  double refresh_rate = 1.458285522911378;  // a2, MARRR's experiment 1
  double judder = 1.191249243548508;        // a3, MARRR's experiment 3
};

/// A model's account of each measurement, in the measurement's unit, in the same order.
struct ExperimentPredictions {
  std::vector<double> scores;
  std::array<double, kExperiments> rmse{};  // NaN for experiments without measurements
  double pooled_rmse_jnd = 0;               // over all measurements that calibrate
};

/// Ds and Dt of every measurement. Errors: ArgumentError for a texture that `textures` lacks.
std::vector<CamojabQuality> distortions(const QualityExperiments&, const CamojabModel&);

/// Differences from the baselines times the multipliers; for the external experiments, whose scales
/// are unrelated, an affine least-squares fit of score on Q.
ExperimentPredictions camojab_predictions(const QualityExperiments&,
                                          const std::vector<CamojabQuality>& distortions,
                                          const CamojabWeights&, const CamojabMultipliers&);
ExperimentPredictions camojab_predictions(const QualityExperiments&, const CamojabModel& = {},
                                          const CamojabMultipliers& = {});

/// Quality differences from the baselines (judder energies for experiment 3), with one
/// least-squares scale for the three VRS blocks together and one each for experiments 1 and 3;
/// affine for the external ones. Predictable motion.
ExperimentPredictions marrr_predictions(const QualityExperiments&,
                                        MotionQualityPreset = MotionQualityPreset::kReleased);

struct CamojabFit {
  CamojabWeights weights;
  CamojabMultipliers multipliers;
  ExperimentPredictions predictions;
  bool converged = false;
  std::string report;  // one line
};

/// Refits weights and multipliers, and beta if asked, by least squares over all measurements that
/// calibrate. Weights and multipliers are known only as products, so a1 keeps its value.
CamojabFit fit_camojab(const QualityExperiments&, const CamojabModel& start, bool fit_beta);

/// One row of an ablation: how the predictions change when the model does.
struct AblationRow {
  std::string change;
  ExperimentPredictions kept;  // with the released weights and multipliers
  CamojabFit refitted;         // beta kept unless asked
};

/// The changes: each stage left out (thesis, table 5.4), then each difference between thesis and
/// released program.
struct CamojabVariant {
  std::string change;
  CamojabModel model;
};
std::vector<CamojabVariant> camojab_variants();
AblationRow ablate(const QualityExperiments&, const CamojabVariant&, bool fit_beta);

}  // namespace wheatstone
