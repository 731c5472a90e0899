#include "rendering/motion_quality/marrr.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "vectors.h"

namespace wheatstone {
namespace {

constexpr auto kReleased = MotionQualityPreset::kReleased;
constexpr auto kPublished = MotionQualityPreset::kPublished;

Motion motion_of(const CsvTable& t, std::size_t row) {
  return t.number(row, "predictable") != 0 ? Motion::kPredictable : Motion::kUnpredictable;
}

void expect_close(double value, double expected, const std::string& where) {
  EXPECT_NEAR(value, expected, 1e-9 * std::max(1.0, std::abs(expected))) << where;
}

/// The sets of frequencies that the thesis can be read to mean.
std::vector<double> octaves_from_1() {
  return {1, 2, 4, 8, 16, 32, 64};
}
std::vector<double> integers_from_1() {
  std::vector<double> out;
  for (int i = 1; i <= 64; ++i) out.push_back(i);
  return out;
}
Marrr with_frequencies(MotionQualityPreset preset, Motion motion, std::vector<double> cpd) {
  MarrrParameters p = MarrrParameters::preset(preset, motion);
  p.frequencies_cpd = std::move(cpd);
  return Marrr(p);
}

TEST(Marrr, BlurEnergyLikeTheReference) {
  const CsvTable t = read_vectors("marrr_energy_blur.csv");
  const Marrr model,
      octaves = with_frequencies(kReleased, Motion::kPredictable, octaves_from_1()),
      integers = with_frequencies(kReleased, Motion::kPredictable, integers_from_1());
  for (std::size_t i = 0; i < t.rows(); ++i) {
    const double sigma = t.number(i, "sigma_deg");
    expect_close(model.blur_energy(sigma), t.number(i, "E_blur_9freq"), t.where(i));
    expect_close(octaves.blur_energy(sigma), t.number(i, "E_blur_octaves_1_64"), t.where(i));
    expect_close(integers.blur_energy(sigma), t.number(i, "E_blur_integers_1_64"), t.where(i));
  }
}

TEST(Marrr, JudderEnergyLikeTheReference) {
  const CsvTable t = read_vectors("marrr_energy_judder.csv");
  for (std::size_t i = 0; i < t.rows(); ++i) {
    const double refresh = t.number(i, "refresh_hz");
    EXPECT_EQ(judder_peak_cpd(refresh), t.number(i, "peak_rho_cpd")) << t.where(i);
    expect_close(
        Marrr(kReleased, motion_of(t, i)).judder_energy(refresh, t.number(i, "velocity_deg_s")),
        t.number(i, "E_judder"), t.where(i));
  }
}

TEST(Marrr, QualityLikeTheReference) {
  const CsvTable t = read_vectors("marrr_quality.csv");
  ASSERT_GT(t.rows(), 0u);
  for (std::size_t i = 0; i < t.rows(); ++i) {
    const double native = t.number(i, "native_width_px") / t.number(i, "fov_deg"),
                 persistence = t.number(i, "persistence");
    const MarrrDisplay a{t.number(i, "refreshA_hz"), native * t.number(i, "resolution_reductionA"),
                         persistence},
        b{t.number(i, "refreshB_hz"), native, persistence};
    const double speed = t.number(i, "velocity_deg_s");
    const Motion motion = motion_of(t, i);
    const std::pair<const char*, Marrr> models[] = {
        {"Q_released", Marrr(kReleased, motion)},
        {"Q_thesis_pa_pb_9freq", Marrr(kPublished, motion)},
        {"Q_thesis_pa_pb_octaves_1_64", with_frequencies(kPublished, motion, octaves_from_1())},
        {"Q_thesis_pa_pb_integers_1_64", with_frequencies(kPublished, motion, integers_from_1())}};
    for (const auto& [column, model] : models)
      expect_close(model.quality_difference_jnd(a, b, speed), t.number(i, column), t.where(i));
  }
}

MarrrBudget budget_of(const CsvTable& t, std::size_t row) {
  MarrrBudget budget;
  budget.fraction = t.number(row, "bandwidth_fraction");
  return budget;
}

TEST(Marrr, BudgetCurvesLikeTheReference) {
  const CsvTable t = read_vectors("marrr_optimum_curves.csv");
  ASSERT_GT(t.rows(), 0u);
  for (std::size_t i = 0; i < t.rows(); ++i) {
    const MarrrOptimum o = Marrr(kReleased, motion_of(t, i))
                               .spend(budget_of(t, i), static_cast<int>(t.number(i, "refresh_hz")),
                                      t.number(i, "velocity_deg_s"));
    expect_close(o.resolution_reduction, t.number(i, "resolution_reduction"), t.where(i));
    expect_close(o.quality_jnd, t.number(i, "Q_vs_reference"), t.where(i));
  }
}

// The optimum is flat: another refresh rate is as good when the quality reached is.
TEST(Marrr, OptimumReachesTheQualityOfTheReference) {
  const CsvTable t = read_vectors("marrr_optimum.csv");
  ASSERT_GT(t.rows(), 0u);
  for (std::size_t i = 0; i < t.rows(); ++i) {
    const Marrr model(kReleased, motion_of(t, i));
    const MarrrBudget budget = budget_of(t, i);
    const double speed = t.number(i, "velocity_deg_s");
    const MarrrOptimum o = model.optimum(budget, speed);
    expect_close(o.quality_jnd, t.number(i, "Q_vs_reference"), t.where(i));
    for (int refresh = 50; refresh <= 165; refresh += 5)
      EXPECT_LE(model.spend(budget, refresh, speed).quality_jnd, o.quality_jnd) << t.where(i);
  }
}

TEST(Marrr, BetterMeansPositive) {
  const Marrr model;
  const MarrrDisplay slow{60, 40}, fast{144, 40}, coarse{60, 20}, flashed{60, 40, 0.2};
  EXPECT_GT(model.quality_difference_jnd(fast, slow, 20), 0);
  EXPECT_LT(model.quality_difference_jnd(coarse, slow, 20), 0);
  EXPECT_GT(model.quality_difference_jnd(flashed, slow, 20), 0);
  EXPECT_DOUBLE_EQ(model.quality_difference_jnd(fast, slow, 20),
                   -model.quality_difference_jnd(slow, fast, 20));
}

TEST(MarrrTable, GivesOptimaAtItsNodesAndStaysInBudgetBetween) {
  const Marrr model;
  const MarrrTable table(model, {0, 10, 20, 40}, {0.2, 0.5, 1});
  for (std::size_t s = 0; s < 4; ++s)
    for (std::size_t f = 0; f < 3; ++f) {
      MarrrBudget budget;
      budget.fraction = table.fractions()[f];
      const MarrrOptimum direct = model.optimum(budget, table.speeds_deg_per_s()[s]),
                         found = table.lookup(table.speeds_deg_per_s()[s], budget.fraction);
      EXPECT_EQ(table.at(s, f).refresh_hz, direct.refresh_hz);
      EXPECT_EQ(found.refresh_hz, direct.refresh_hz);
      EXPECT_DOUBLE_EQ(found.resolution_reduction, direct.resolution_reduction);
    }
  for (const double speed : {3.0, 17.5, 60.0})
    for (const double fraction : {0.1, 0.3, 0.8}) {
      const MarrrOptimum o = table.lookup(speed, fraction);
      EXPECT_GE(o.refresh_hz, 50);
      EXPECT_LE(o.refresh_hz, 165);
      EXPECT_LE(o.refresh_hz * o.resolution_reduction * o.resolution_reduction,
                165 * fraction * (1 + 1e-12));
    }
  EXPECT_EQ(table.lookup(1000, 0.5).refresh_hz, table.at(3, 1).refresh_hz);
}

TEST(Marrr, ImpossibleArgumentsAreRefused) {
  const Marrr model;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const MarrrDisplay good{60, 40};
  for (const double bad : {-1.0, nan}) {
    EXPECT_THROW(model.blur_energy(bad), ArgumentError);
    EXPECT_THROW(model.judder_energy(60, bad), ArgumentError);
    EXPECT_THROW(model.quality_difference_jnd(good, good, bad), ArgumentError);
  }
  for (const double bad : {0.0, -1.0, nan}) {
    EXPECT_THROW(model.judder_energy(bad, 10), ArgumentError);
    EXPECT_THROW(model.quality_difference_jnd({bad, 40}, good, 10), ArgumentError);
    EXPECT_THROW(model.quality_difference_jnd(good, {60, bad}, 10), ArgumentError);
    EXPECT_THROW(model.quality_difference_jnd(good, {60, 40, bad}, 10), ArgumentError);
    MarrrBudget budget;
    budget.fraction = bad;
    EXPECT_THROW(model.optimum(budget, 10), ArgumentError);
    EXPECT_THROW(MarrrTable(model, {0, 10}, {bad}), ArgumentError);
  }
  EXPECT_THROW(model.quality_difference_jnd(good, {60, 40, 1.01}, 10), ArgumentError);
  MarrrBudget backwards;
  backwards.min_refresh_hz = 166;
  EXPECT_THROW(model.optimum(backwards, 10), ArgumentError);
  EXPECT_THROW(MarrrTable(model, {}, {1}), ArgumentError);
  EXPECT_THROW(MarrrTable(model, {10, 10}, {1}), ArgumentError);
  const MarrrTable table(model, {0, 10}, {1});
  EXPECT_THROW(table.lookup(nan, 1), ArgumentError);
  EXPECT_THROW(table.lookup(1, 0), ArgumentError);
  EXPECT_THROW(table.at(2, 0), ArgumentError);
}

TEST(MotionQualityPreset, NamesGoBothWays) {
  for (const auto preset : {kReleased, kPublished})
    EXPECT_EQ(motion_quality_preset_from_string(to_string(preset)), preset);
  EXPECT_THROW(motion_quality_preset_from_string("Released"), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
