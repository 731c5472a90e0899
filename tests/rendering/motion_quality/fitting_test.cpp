#include "rendering/motion_quality/fitting.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include "core/csv.h"
#include "core/error.h"
#include "rendering/motion_quality/grey_texture.h"
#include "tests/shared_data.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

namespace fs = std::filesystem;

const fs::path kData = shared_folder("reference/perception/data"),
               kTextures = shared_folder("reference/perception/textures");

const QualityExperiments& experiments() {
  static const QualityExperiments all = read_quality_experiments(kData, kTextures);
  return all;
}

void expect_rmse(const ExperimentPredictions& p, const std::vector<double>& expected,
                 double tolerance) {
  for (std::size_t e = 0; e < expected.size(); ++e)
    EXPECT_NEAR(p.rmse[e], expected[e], tolerance) << kExperimentNames[e];
}

TEST(QualityExperiments, HoldsAllMeasurements) {
  REQUIRE_SHARED(kData);
  const std::size_t counts[kExperiments] = {36, 36, 36, 72, 4, 28, 4, 3};
  for (std::size_t e = 0; e < kExperiments; ++e)
    EXPECT_EQ(experiments().of(static_cast<Experiment>(e)).size(), counts[e]);
  EXPECT_EQ(experiments().textures.size(), 5u);
  for (const QualityMeasurement& m : experiments().measurements) {
    const QualityMeasurement& base = experiments().measurements[m.baseline];
    EXPECT_EQ(base.experiment, m.experiment);
    EXPECT_LE(m.score_low, m.score);
    EXPECT_GE(m.score_high, m.score);
    if (calibrates(m.experiment)) {
      EXPECT_EQ(base.score, 0);
    }
  }
}

// The released program's own values stand beside the measurements.
TEST(Fitting, DistortionsLikeTheReleasedProgram) {
  REQUIRE_SHARED(kData);
  const std::vector<CamojabQuality> d = distortions(experiments(), {});
  const auto expect_column = [&](const char* file, const char* spatial, const char* temporal,
                                 std::size_t first) {
    const CsvTable t = CsvTable::read(kData / file);
    for (std::size_t i = 0; i < t.rows(); ++i) {
      const double ds = t.number(i, spatial), dt = t.number(i, temporal);
      EXPECT_NEAR(d[first + i].spatial_distortion, ds, 1e-4 + 1e-5 * ds) << t.where(i);
      EXPECT_NEAR(d[first + i].temporal_distortion, dt, 1e-4 + 1e-5 * dt) << t.where(i);
    }
  };
  expect_column("vrs_experiment_jnd.csv", "model_Ds", "model_Dt", 0);
  expect_column("marrr_experiment3.csv", "camojab_Ds_v25", "camojab_Dt_v25",
                experiments().of(Experiment::kJudder)[0]);
}

TEST(Fitting, Table53OfCamojab) {
  REQUIRE_SHARED(kData);
  const ExperimentPredictions p = camojab_predictions(experiments());
  expect_rmse(p, {0.7401, 0.5704, 0.5344, 0.3838, 0.0359, 0.4190, 0.2775, 0.6907}, 2e-4);
  EXPECT_NEAR(p.pooled_rmse_jnd, 0.5333, 2e-4);
}

TEST(Fitting, WithoutMultipliersTheScalesDoNotFit) {
  REQUIRE_SHARED(kData);
  expect_rmse(camojab_predictions(experiments(), {}, {1, 1, 1}), {1.571, 0.726, 0.601, 1.045},
              1e-3);
}

TEST(Fitting, Table53OfMarrr) {
  REQUIRE_SHARED(kData);
  expect_rmse(marrr_predictions(experiments()),
              {1.818, 1.547, 1.147, 0.5459, 0.0359, 0.5503, 0.1510, 0.333}, 6e-4);
}

// From elsewhere the solver must come back to the released weights: they are the optimum.
TEST(Fitting, RefittingFindsTheReleasedWeights) {
  REQUIRE_SHARED(kData);
  CamojabModel start;
  start.weights = {-3, -4, 0.359663511318103};
  const CamojabFit fit = fit_camojab(experiments(), start, false);
  const CamojabWeights released;
  const CamojabMultipliers multipliers;
  EXPECT_TRUE(fit.converged) << fit.report;
  EXPECT_NEAR(fit.weights.spatial, released.spatial, 1e-3);
  EXPECT_NEAR(fit.weights.temporal, released.temporal, 1e-3);
  EXPECT_NEAR(fit.multipliers.refresh_rate, multipliers.refresh_rate, 1e-3);
  EXPECT_NEAR(fit.multipliers.judder, multipliers.judder, 1e-3);
}

// The released exponent is the best one: its neighbours fit worse, whatever the weights.
TEST(Fitting, OtherExponentsFitWorse) {
  REQUIRE_SHARED(kData);
  for (const double factor : {0.97, 1.03}) {
    CamojabModel other;
    other.weights.beta *= factor;
    EXPECT_GT(fit_camojab(experiments(), other, false).predictions.pooled_rmse_jnd, 0.5333);
  }
}

/// Experiments on one texture whose outcome the model itself decides.
QualityExperiments perfect_experiments(const CamojabModel& truth, const CamojabMultipliers& a) {
  QualityExperiments all;
  all.textures.emplace("noise128", CamojabTexture(procedural_texture("noise128")));
  const auto add = [&](Experiment experiment, const CamojabConditions& c, std::size_t baseline) {
    all.measurements.push_back({experiment, "noise128", c, 0, 0, 0, baseline});
  };
  for (const double speed : {2.0, 20.0}) {
    const std::size_t full = all.measurements.size();
    for (const double rate : {1.0, 0.5, 0.25})
      add(Experiment::kVrsPc, {50, 144, speed, 1, 150, 3, rate, 1}, full);
    const std::size_t slowest = all.measurements.size();
    for (const double refresh : {50, 90, 165})
      add(Experiment::kRefreshRate, {50, refresh, speed, 1, 100, 1, 1, 1}, slowest);
  }
  const std::size_t fast = all.measurements.size();
  for (const double refresh : {82.5, 50.0})
    add(Experiment::kJudder, {50, refresh, 25, 1, 100, 1, 1, 1}, fast);
  const std::vector<double> scores = camojab_predictions(all, truth, a).scores;
  for (std::size_t i = 0; i < scores.size(); ++i) all.measurements[i].score = scores[i];
  return all;
}

TEST(Fitting, FindsTheWeightsOfAPerfectWorld) {
  CamojabModel truth;
  truth.weights = {-2.5, -4.5, 0.42};
  CamojabMultipliers multipliers;
  multipliers.refresh_rate = 1.1;
  multipliers.judder = 0.8;
  const CamojabFit fit = fit_camojab(perfect_experiments(truth, multipliers), {}, true);
  EXPECT_TRUE(fit.converged) << fit.report;
  EXPECT_NEAR(fit.weights.beta, 0.42, 1e-5);
  EXPECT_NEAR(fit.weights.spatial, -2.5, 1e-4);
  EXPECT_NEAR(fit.weights.temporal, -4.5, 1e-4);
  EXPECT_NEAR(fit.multipliers.refresh_rate, 1.1, 1e-4);
  EXPECT_NEAR(fit.multipliers.judder, 0.8, 1e-4);
  EXPECT_LT(fit.predictions.pooled_rmse_jnd, 1e-5);
}

/// RMSE of PC, Mobile, VR, experiments 1 and 3 for single changes of the model.
struct Change {
  std::string name;
  std::vector<double> kept, refitted;

  friend void PrintTo(const Change& change, std::ostream* out) { *out << change.name; }
};
class SingleChange : public ::testing::TestWithParam<Change> {};

TEST_P(SingleChange, CostsWhatTheReferenceSays) {
  REQUIRE_SHARED(kData);
  for (const CamojabVariant& variant : camojab_variants()) {
    if (variant.change != GetParam().name) continue;
    const AblationRow row = ablate(experiments(), variant, false);
    expect_rmse(row.kept, GetParam().kept, 1e-3);
    expect_rmse(row.refitted.predictions, GetParam().refitted, 1e-3);
    EXPECT_TRUE(row.refitted.converged) << row.refitted.report;
    return;
  }
  FAIL() << "no variant " << GetParam().name;
}

INSTANTIATE_TEST_SUITE_P(Fitting, SingleChange,
                         ::testing::Values(Change{"released",
                                                  {0.740, 0.570, 0.534, 0.384, 0.036},
                                                  {0.740, 0.571, 0.534, 0.383, 0.036}},
                                           Change{"Euclidean radius",
                                                  {0.728, 0.712, 0.547, 0.471, 0.042},
                                                  {0.759, 0.659, 0.530, 0.393, 0.036}},
                                           Change{"comb at full interval, one side",
                                                  {0.822, 0.729, 0.681, 0.815, 0.064},
                                                  {0.788, 0.575, 0.575, 0.384, 0.036}},
                                           Change{"comb at full interval, two sides",
                                                  {0.830, 0.787, 0.684, 0.815, 0.064},
                                                  {0.793, 0.613, 0.571, 0.387, 0.036}},
                                           Change{"alias at omega/v",
                                                  {0.740, 0.553, 0.534, 0.384, 0.036},
                                                  {0.737, 0.557, 0.536, 0.382, 0.036}},
                                           Change{"published",
                                                  {0.865, 0.890, 0.694, 0.999, 0.079},
                                                  {0.810, 0.674, 0.561, 0.391, 0.036}}),
                         [](const auto& test) {
                           std::string name;
                           for (const char c : test.param.name)
                             name += std::isalnum(c) ? std::string(1, c) : "";
                           return name;
                         });

// The reference gives the refitted weights of `published` from a fit that leans a little more on
// experiment 1; the errors agree all the same.
TEST(Fitting, RefittedPublishedPresetLikeTheReference) {
  REQUIRE_SHARED(kData);
  const CamojabFit fit =
      fit_camojab(experiments(), CamojabModel::preset(MotionQualityPreset::kPublished), false);
  const CamojabWeights& w = fit.weights;
  const CamojabMultipliers& a = fit.multipliers;
  EXPECT_NEAR(a.shading_rate * w.spatial, -3.362, 0.05);
  EXPECT_NEAR(a.shading_rate * w.temporal, -2.928, 0.05);
  EXPECT_NEAR(a.refresh_rate * w.spatial, -7.360, 0.05);
  EXPECT_NEAR(a.refresh_rate * w.temporal, -6.410, 0.05);
  EXPECT_NEAR(a.judder, 1.819, 1e-3);
}

// Leaving a stage out and refitting can only be judged worse than the whole model.
TEST(Fitting, EveryStageEarnsItsPlace) {
  REQUIRE_SHARED(kData);
  const double whole = camojab_predictions(experiments()).pooled_rmse_jnd;
  int judged = 0;
  for (const CamojabVariant& variant : camojab_variants()) {
    if (!variant.change.starts_with("no ")) continue;
    const AblationRow row = ablate(experiments(), variant, false);
    EXPECT_GT(row.refitted.predictions.pooled_rmse_jnd, whole) << variant.change;
    EXPECT_LE(row.refitted.predictions.pooled_rmse_jnd, row.kept.pooled_rmse_jnd + 1e-9)
        << variant.change;
    ++judged;
  }
  EXPECT_EQ(judged, 8);
}

/// A copy of the measurements, to be damaged.
class DamagedExperiments : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kData)) return;
    for (const auto& file : fs::directory_iterator(kData))
      fs::copy_file(file.path(), folder_.path / file.path().filename());
    for (const auto& file : fs::directory_iterator(folder_.path))
      fs::permissions(file.path(), fs::perms::owner_write, fs::perm_options::add);
  }
  void expect_refused(const std::string& part) {
    try {
      read_quality_experiments(folder_.path, kTextures);
      FAIL() << part;
    } catch (const FileError& e) {
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
  }
  TemporaryFolder folder_;
};

TEST_F(DamagedExperiments, AreRefusedByNameAndLine) {
  REQUIRE_SHARED(kData);
  const fs::path judder = folder_.path / "marrr_experiment3.csv";
  const CsvTable good = CsvTable::read(judder);

  CsvTable bad = good;
  bad.set_column("jnd_predictable", std::vector<std::string>{"0.3", "nan", "0", "0"});
  bad.write(judder);
  expect_refused("marrr_experiment3.csv:3");

  bad = good;
  bad.set_column("refresh_hz", std::vector<double>{50, 60, 72, 80});  // no 82.5 Hz left
  bad.write(judder);
  expect_refused("no row to compare with");

  std::ofstream(judder) << "refresh_hz,jnd_predictable\n50,0.3,7\n";
  expect_refused("marrr_experiment3.csv: line 2");
  std::ofstream(judder) << "refresh_hz,jnd\n50,0.3\n";
  expect_refused("jnd_predictable");
  good.write(judder);

  const fs::path vrs = folder_.path / "vrs_experiment_jnd.csv";
  CsvTable blocks = CsvTable::read(vrs);
  std::vector<std::string> names(blocks.rows(), "PC");
  names[4] = "Cinema";
  blocks.set_column("block", names);
  blocks.write(vrs);
  expect_refused("vrs_experiment_jnd.csv:6");

  fs::remove(vrs);
  expect_refused("vrs_experiment_jnd.csv");
}

TEST(QualityExperiments, MissingTextureIsNamed) {
  REQUIRE_SHARED(kData);
  try {
    read_quality_experiments(kData, "/nonexistent");
    FAIL();
  } catch (const FileError& e) {
    EXPECT_NE(std::string(e.what()).find("/nonexistent/"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace wheatstone
