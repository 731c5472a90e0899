#include "rendering/motion_quality/camojab.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "core/error.h"
#include "core/random.h"
#include "rendering/motion_quality/grey_texture.h"
#include "tests/shared_data.h"
#include "vectors.h"

namespace wheatstone {
namespace {

CamojabConditions conditions_of(const CsvTable& t, std::size_t row) {
  return {t.number(row, "ppd"),
          t.number(row, "refresh_hz"),
          t.number(row, "velocity_deg_s"),
          t.number(row, "persistence"),
          t.number(row, "mean_lum_cd_m2"),
          t.number(row, "mip_level"),
          t.number(row, "srx"),
          t.number(row, "sry")};
}

const CamojabTexture& procedural(const std::string& name) {
  static std::map<std::string, CamojabTexture> spectra;
  const auto known = spectra.find(name);
  if (known != spectra.end()) return known->second;
  return spectra.emplace(name, CamojabTexture(procedural_texture(name))).first->second;
}

// The vectors' tolerances: beta amplifies rounding in bins that are 0 but for rounding.
void expect_spatial(double value, double expected, const std::string& where) {
  EXPECT_NEAR(value, expected, 1e-4 + 1e-5 * std::abs(expected)) << where;
}
void expect_temporal(double value, double expected, const std::string& where) {
  EXPECT_NEAR(value, expected, 2e-5 + 1e-5 * std::abs(expected)) << where;
}

/// Evaluates every row of a vector file and judges Ds, Dt and Q.
void expect_vectors(const std::string& file, MotionQualityPreset preset) {
  const CsvTable t = read_vectors(file);
  std::map<std::string, std::vector<std::size_t>> rows;
  for (std::size_t i = 0; i < t.rows(); ++i) rows[t.text(i, "texture")].push_back(i);
  ASSERT_FALSE(rows.empty());
  for (const auto& [name, members] : rows) {
    std::vector<CamojabConditions> conditions;
    for (const std::size_t i : members) conditions.push_back(conditions_of(t, i));
    const auto results =
        Camojab(procedural(name), CamojabModel::preset(preset)).evaluate(conditions);
    for (std::size_t m = 0; m < members.size(); ++m) {
      const std::size_t i = members[m];
      expect_spatial(results[m].spatial_distortion, t.number(i, "Ds"), t.where(i));
      expect_temporal(results[m].temporal_distortion, t.number(i, "Dt"), t.where(i));
      EXPECT_NEAR(results[m].quality, t.number(i, "Q"), 5e-4 + 2e-5 * std::abs(t.number(i, "Q")))
          << t.where(i);
    }
  }
}

TEST(Camojab, ReleasedPresetLikeTheReference) {
  expect_vectors("camojab_vectors.csv", MotionQualityPreset::kReleased);
}

TEST(Camojab, PublishedPresetLikeTheReference) {
  expect_vectors("camojab_published_vectors.csv", MotionQualityPreset::kPublished);
}

// Where the clipping edge falls on a bin, the released program lets rounding decide.
TEST(Camojab, EdgeRowsFollowTheIntegerRule) {
  const CsvTable t = read_vectors("camojab_edge_rows.csv");
  ASSERT_GT(t.rows(), 0u);
  for (std::size_t i = 0; i < t.rows(); ++i) {
    const auto q = Camojab(procedural(t.text(i, "texture"))).evaluate(conditions_of(t, i));
    expect_spatial(q.spatial_distortion, t.number(i, "Ds_exact_bins"), t.where(i));
    expect_temporal(q.temporal_distortion, t.number(i, "Dt_exact_bins"), t.where(i));
  }
}

/// Judges every stage of every row whose texture is procedural, or is not.
int expect_stages(bool of_procedural,
                  const std::function<CamojabTexture(const std::string&)>& texture) {
  const CsvTable t = read_vectors("camojab_stages.csv");
  const std::vector<std::string> names = procedural_texture_names();
  int judged = 0;
  for (std::size_t i = 0; i < t.rows(); ++i) {
    const std::string& name = t.text(i, "texture");
    if ((std::find(names.begin(), names.end(), name) != names.end()) != of_procedural) continue;
    const CamojabStages s = Camojab(texture(name)).stages(conditions_of(t, i));
    const std::pair<const char*, double> energies[] = {{"E_ref_nocsf", s.reference},
                                                       {"E_ref_csf", s.reference_weighted},
                                                       {"E_mip_nocsf", s.mip_blur},
                                                       {"E_mip_csf", s.mip_blur_weighted},
                                                       {"E_comb_csf", s.aliasing_weighted},
                                                       {"E_clip_csf", s.clipping_weighted},
                                                       {"E_final_csf", s.motion_blur_weighted}};
    for (const auto& [column, value] : energies)
      expect_spatial(value, t.number(i, column), t.where(i) + " " + column);
    EXPECT_EQ(s.alias_shift_bins, t.number(i, "alias_shift_bins")) << t.where(i);
    expect_spatial(s.result.spatial_distortion, t.number(i, "Ds"), t.where(i));
    expect_temporal(s.result.temporal_distortion, t.number(i, "Dt"), t.where(i));
    ++judged;
  }
  return judged;
}

TEST(Camojab, StagesLikeTheReference) {
  EXPECT_EQ(expect_stages(true, procedural), 12);
}

// The textures of the experiments: the reference had them in 64 bits, the files have 32.
CamojabTexture photographed(const std::string& name) {
  const auto folder = shared_folder("reference/perception/textures");
  return CamojabTexture(read_grey_texture(folder / (name + ".exr")));
}

TEST(Camojab, StagesOfPhotographedTexturesLikeTheReference) {
  REQUIRE_SHARED(shared_folder("reference/perception/textures"));
  EXPECT_EQ(expect_stages(false, photographed), 6);
}

TEST(Camojab, PhotographedTexturesLikeTheReference) {
  REQUIRE_SHARED(shared_folder("reference/perception/textures"));
  const CsvTable t = read_vectors("camojab_original_textures.csv");
  ASSERT_GT(t.rows(), 0u);
  for (std::size_t i = 0; i < t.rows(); ++i) {
    const auto q = Camojab(photographed(t.text(i, "texture"))).evaluate(conditions_of(t, i));
    expect_spatial(q.spatial_distortion, t.number(i, "Ds"), t.where(i));
    expect_spatial(q.temporal_distortion, t.number(i, "Dt"), t.where(i));
    EXPECT_NEAR(q.quality, t.number(i, "Q"), 7e-4 + 1e-5 * std::abs(t.number(i, "Q")))
        << t.where(i);
  }
}

/// Conditions over the whole range of the model, repeatable.
CamojabConditions random_conditions(std::uint64_t seed) {
  RandomStream random(seed, 0);
  const auto between = [&](double low, double high) {
    return low + (high - low) * random.uniform();
  };
  return {between(10, 100),  between(24, 240), between(0, 80),     between(0.05, 1),
          between(0.1, 500), between(0, 6),    between(0.05, 1.0), between(0.05, 1.0)};
}

// The shortcuts (folding, tables, sharing) against the plain model on whole spectra.
TEST(Camojab, FastEvaluationEqualsTheStages) {
  std::map<std::string, std::function<void(CamojabModel&)>> variants = {
      {"as it is", [](CamojabModel&) {}},
      {"no mip blur", [](CamojabModel& m) { m.mip_blur = false; }},
      {"no aliasing", [](CamojabModel& m) { m.aliasing = false; }},
      {"no clipping", [](CamojabModel& m) { m.clipping = false; }},
      {"no judder", [](CamojabModel& m) { m.judder = false; }},
      {"no hold blur", [](CamojabModel& m) { m.hold_blur = false; }},
      {"no eye blur", [](CamojabModel& m) { m.eye_blur = false; }},
      {"other beta", [](CamojabModel& m) { m.weights.beta = 0.8; }}};
  std::uint64_t seed = 0;
  for (const auto preset : {MotionQualityPreset::kReleased, MotionQualityPreset::kPublished})
    for (const auto& [name, change] : variants) {
      CamojabModel model = CamojabModel::preset(preset);
      change(model);
      const Camojab camojab(procedural("noise128"), model);
      const CamojabConditions c = random_conditions(++seed);
      const CamojabQuality fast = camojab.evaluate(c), plain = camojab.stages(c).result;
      const double scale = camojab.stages(c).reference_weighted;
      EXPECT_NEAR(fast.spatial_distortion, plain.spatial_distortion, 1e-11 * scale) << name;
      EXPECT_NEAR(fast.temporal_distortion, plain.temporal_distortion, 1e-11 * scale) << name;
      EXPECT_NEAR(fast.quality, plain.quality, 1e-10 * scale) << name;
    }
}

TEST(Camojab, ResultsDoNotDependOnTheNumberOfThreadsOrTheBatch) {
  const Camojab camojab(procedural("noise128"));
  std::vector<CamojabConditions> conditions;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    conditions.push_back(random_conditions(seed));
    if (seed % 3) {  // some share what a batch computes once
      conditions.back().mip_level = conditions[0].mip_level;
      conditions.back().shading_rate_x = conditions.back().shading_rate_y = 0.5;
    }
  }
  const auto parallel = camojab.evaluate(conditions);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto serial = camojab.evaluate(conditions);
  for (std::size_t i = 0; i < conditions.size(); ++i) {
    const CamojabQuality alone = camojab.evaluate(conditions[i]);
    for (const CamojabQuality& q : {serial[i], alone}) {
      EXPECT_EQ(parallel[i].spatial_distortion, q.spatial_distortion) << i;
      EXPECT_EQ(parallel[i].temporal_distortion, q.temporal_distortion) << i;
      EXPECT_EQ(parallel[i].quality, q.quality) << i;
    }
  }
}

TEST(Camojab, MotionAndCoarseShadingCostQuality) {
  const Camojab camojab(procedural("noise128"));
  CamojabConditions c{50, 60, 20, 1, 100, 1, 1, 1};
  const CamojabQuality base = camojab.evaluate(c);
  const auto with = [&](auto member, double value) {
    CamojabConditions changed = c;
    changed.*member = value;
    return camojab.evaluate(changed);
  };
  EXPECT_GT(with(&CamojabConditions::refresh_hz, 144).quality, base.quality);
  EXPECT_LT(with(&CamojabConditions::speed_deg_per_s, 40).quality, base.quality);
  EXPECT_LT(with(&CamojabConditions::shading_rate_x, 0.25).quality, base.quality);
  EXPECT_LT(with(&CamojabConditions::mip_level, 4).spatial_distortion * -1,
            base.spatial_distortion * -1);
  EXPECT_EQ(with(&CamojabConditions::speed_deg_per_s, 0).temporal_distortion, 0);
}

TEST(Camojab, CropsLargeTexturesAtTheTopLeft) {
  const cv::Mat1d large = procedural_texture("noise640x544");
  const CamojabTexture whole(large), crop(large(cv::Rect(0, 0, 512, 512)).clone());
  EXPECT_TRUE((whole.amplitude() == crop.amplitude()).all());
}

TEST(Camojab, SpectrumOfOneTexelIsFlat) {
  const CamojabTexture texture(cv::Mat1d(1, 1, 0.5));
  EXPECT_NEAR((texture.amplitude() - 0.5).abs().maxCoeff(), 0, 1e-15);
}

TEST(Camojab, ImpossibleTexturesAreRefused) {
  EXPECT_THROW(CamojabTexture(cv::Mat1d()), ArgumentError);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity()}) {
    cv::Mat1d grey(4, 5, 0.5);
    grey(3, 2) = bad;
    try {
      CamojabTexture texture(grey);
      FAIL() << bad;
    } catch (const ArgumentError& e) {
      EXPECT_NE(std::string(e.what()).find("column 2, row 3"), std::string::npos) << e.what();
    }
  }
}

TEST(Camojab, ImpossibleModelsAreRefused) {
  for (const double bad : {0.0, -1.0, 4.1, std::numeric_limits<double>::quiet_NaN()}) {
    CamojabModel model;
    model.weights.beta = bad;
    EXPECT_THROW(Camojab(procedural("noise128"), model), ArgumentError) << bad;
  }
  CamojabModel model;
  model.alias_position = 0;
  EXPECT_THROW(Camojab(procedural("noise128"), model), ArgumentError);
}

TEST(Camojab, ImpossibleConditionsAreRefused) {
  const Camojab camojab(procedural("noise128"));
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  using C = CamojabConditions;
  const std::vector<std::pair<double C::*, std::vector<double>>> bad = {
      {&C::ppd, {0, -1, nan, infinity}},
      {&C::refresh_hz, {0, -60, nan, infinity}},
      {&C::speed_deg_per_s, {-0.1, nan, infinity}},
      {&C::persistence, {0, -0.5, 1.01, nan}},
      {&C::luminance_cd_m2, {0, -1, nan, infinity}},
      {&C::mip_level, {-1, nan, infinity}},
      {&C::shading_rate_x, {0, -0.5, 1.5, nan}},
      {&C::shading_rate_y, {0, 2, nan}}};
  const C good{60, 60, 15, 1, 150, 2, 1, 1};
  for (const auto& [member, values] : bad)
    for (const double value : values) {
      C c = good;
      c.*member = value;
      EXPECT_THROW(camojab.evaluate(c), ArgumentError) << value;
      EXPECT_THROW(camojab.stages(c), ArgumentError) << value;
      try {
        camojab.evaluate(std::vector{good, c});
        FAIL() << value;
      } catch (const ArgumentError& e) {
        EXPECT_NE(std::string(e.what()).find("conditions 1: "), std::string::npos) << e.what();
      }
    }
}

}  // namespace
}  // namespace wheatstone
