#include "rendering/motion_quality/marrr.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "rendering/motion_quality/contrast_sensitivity.h"

namespace wheatstone {
namespace {

using std::numbers::pi;

// Fitted to the thesis's experiments 1 and 3 (full digits of the released program).
constexpr double kBlurWeight = 1.47281929556791;  // wP = wO
constexpr double kJudderWeight = 2.21867722216986;
constexpr double kBlurThreshold = 383.5854418393431, kBlurExponent = 1.83564239998305;
constexpr double kJudderExponent = 2.574657335762098;
constexpr double kFittedField_deg = 10, kFittedLuminance_cd_m2 = 100;

void require(bool holds, const char* what, double value, const char* remedy) {
  if (!holds || !std::isfinite(value))
    throw ArgumentError(fmt::format("{} of {} is impossible", what, value), remedy);
}

void require_speed(double speed_deg_per_s) {
  require(speed_deg_per_s >= 0, "a speed (deg/s)", speed_deg_per_s,
          "give the magnitude of the velocity, 0 or above");
}

void require_refresh(double refresh_hz) {
  require(refresh_hz > 0, "a refresh rate (Hz)", refresh_hz, "give one above 0");
}

void require_valid(const MarrrBudget& b) {
  require(b.fraction > 0, "a fraction of the budget", b.fraction, "give one above 0");
  if (b.min_refresh_hz < 1 || b.max_refresh_hz < b.min_refresh_hz)
    throw ArgumentError(fmt::format("refresh rates from {} to {} Hz are no range", b.min_refresh_hz,
                                    b.max_refresh_hz),
                        "give 1 <= least <= greatest");
}

void require_ascending(const std::vector<double>& axis, const char* what) {
  if (axis.empty() || !std::is_sorted(axis.begin(), axis.end(), std::less_equal<>()))
    throw ArgumentError(fmt::format("the {} are empty or not ascending", what),
                        "list distinct ones from low to high");
}

/// Neighbours of x on an ascending axis and the weight of the upper one; clamped at the ends.
struct Bracket {
  std::size_t low, high;
  double high_weight;
};
Bracket bracket(const std::vector<double>& axis, double x) {
  const auto above = std::upper_bound(axis.begin(), axis.end(), x);
  if (above == axis.begin()) return {0, 0, 0};
  const auto low = static_cast<std::size_t>(above - axis.begin()) - 1;
  if (above == axis.end()) return {low, low, 0};
  return {low, low + 1, (x - axis[low]) / (axis[low + 1] - axis[low])};
}

double affordable_reduction(const MarrrBudget& b, double refresh_hz) {
  return std::min(1.0, std::sqrt(b.fraction * b.max_refresh_hz / refresh_hz));
}

}  // namespace

MarrrParameters MarrrParameters::preset(MotionQualityPreset preset, Motion motion) {
  const bool released = preset == MotionQualityPreset::kReleased;
  const std::vector<double> octaves = {0.25, 0.5, 1, 2, 4, 8, 16, 32, 64};
  if (motion == Motion::kPredictable)
    return {released ? 0.001528 : 0.001648, released ? 0.072419 : 0.079818, 218.7120058255750,
            octaves};
  return {released ? 0.004517 : 0.004978, released ? 0.160428 : 0.176820, 165.7790637102406,
          octaves};
}

Marrr::Marrr(MotionQualityPreset preset, Motion motion)
    : Marrr(MarrrParameters::preset(preset, motion)) {}

Marrr::Marrr(MarrrParameters parameters) : parameters_(std::move(parameters)) {
  for (const double phi : parameters_.frequencies_cpd)
    sensitivities_.push_back(barten_csf(phi, kFittedLuminance_cd_m2, kFittedField_deg) /
                             kBlurThreshold);
}

double Marrr::blur_energy(double sigma_deg) const {
  require(sigma_deg >= 0, "a blur (deg)", sigma_deg, "give 0 or above");
  double sum = 0;
  for (std::size_t i = 0; i < sensitivities_.size(); ++i) {
    const double phase = pi * parameters_.frequencies_cpd[i] * sigma_deg;
    sum += std::pow(sensitivities_[i] * std::exp(-2 * phase * phase), kBlurExponent);
  }
  return sum;
}

int judder_peak_cpd(double refresh_hz) {
  require_refresh(refresh_hz);
  int best = 1;
  for (int rho = 2; rho <= 50; ++rho)
    if (kelly_csf(rho, refresh_hz) > kelly_csf(best, refresh_hz)) best = rho;
  return best;
}

double Marrr::judder_energy(double refresh_hz, double speed_deg_per_s) const {
  require_speed(speed_deg_per_s);
  // Below its peak the sensitivity is held: coarser aliases are no less visible.
  const double alias_cpd =
      std::max<double>(judder_peak_cpd(refresh_hz), refresh_hz / std::max(speed_deg_per_s, 0.001));
  return std::pow(kelly_csf(alias_cpd, refresh_hz) / parameters_.judder_threshold, kJudderExponent);
}

double Marrr::blur_quality(const MarrrDisplay& d, double speed_deg_per_s) const {
  require_refresh(d.refresh_hz);
  require(d.ppd > 0, "a resolution (ppd)", d.ppd, "give pixels per degree above 0");
  require(d.persistence > 0 && d.persistence <= 1, "a persistence", d.persistence,
          "give the lit part of the frame, above 0 and at most 1");
  const double pursuit =
      d.persistence *
      (parameters_.pursuit_blur_s * speed_deg_per_s + parameters_.pursuit_blur_deg) / pi;
  const double hold = d.persistence * speed_deg_per_s / (d.refresh_hz * pi);
  const double pixel = std::numbers::sqrt2 / (d.ppd * pi);
  return kBlurWeight * (blur_energy(std::hypot(pursuit, hold, pixel)) + blur_energy(pixel));
}

double Marrr::quality_difference_jnd(const MarrrDisplay& a, const MarrrDisplay& b,
                                     double speed_deg_per_s) const {
  require_speed(speed_deg_per_s);
  return blur_quality(a, speed_deg_per_s) - blur_quality(b, speed_deg_per_s) +
         kJudderWeight * (judder_energy(b.refresh_hz, speed_deg_per_s) -
                          judder_energy(a.refresh_hz, speed_deg_per_s));
}

MarrrOptimum Marrr::spend(const MarrrBudget& b, int refresh_hz, double speed_deg_per_s) const {
  require_valid(b);
  require_refresh(refresh_hz);
  const double reduction = affordable_reduction(b, refresh_hz);
  return {refresh_hz, reduction,
          quality_difference_jnd({double(refresh_hz), b.native_ppd * reduction, b.persistence},
                                 {double(b.max_refresh_hz), b.native_ppd, b.persistence},
                                 speed_deg_per_s)};
}

MarrrOptimum Marrr::optimum(const MarrrBudget& b, double speed_deg_per_s) const {
  require_valid(b);
  MarrrOptimum best = spend(b, b.min_refresh_hz, speed_deg_per_s);
  for (int refresh = b.min_refresh_hz + 1; refresh <= b.max_refresh_hz; ++refresh) {
    const MarrrOptimum next = spend(b, refresh, speed_deg_per_s);
    if (next.quality_jnd > best.quality_jnd) best = next;
  }
  return best;
}

MarrrTable::MarrrTable(const Marrr& model, std::vector<double> speeds_deg_per_s,
                       std::vector<double> fractions, MarrrBudget budget)
    : speeds_(std::move(speeds_deg_per_s)), fractions_(std::move(fractions)), budget_(budget) {
  require_ascending(speeds_, "speeds");
  require_ascending(fractions_, "fractions");
  optima_.resize(speeds_.size() * fractions_.size());
  tbb::parallel_for(std::size_t{0}, optima_.size(), [&](std::size_t i) {
    MarrrBudget b = budget;
    b.fraction = fractions_[i % fractions_.size()];
    optima_[i] = model.optimum(b, speeds_[i / fractions_.size()]);
  });
}

const MarrrOptimum& MarrrTable::at(std::size_t speed, std::size_t fraction) const {
  if (speed >= speeds_.size() || fraction >= fractions_.size())
    throw ArgumentError(fmt::format("entry ({}, {}) is outside the table of {} x {}", speed,
                                    fraction, speeds_.size(), fractions_.size()),
                        "use indices of its axes");
  return optima_[speed * fractions_.size() + fraction];
}

MarrrOptimum MarrrTable::lookup(double speed_deg_per_s, double fraction) const {
  require_speed(speed_deg_per_s);
  require(fraction > 0, "a fraction of the budget", fraction, "give one above 0");
  const Bracket s = bracket(speeds_, speed_deg_per_s), f = bracket(fractions_, fraction);
  double refresh = 0, quality = 0;
  for (const auto& [i, wi] : {std::pair{s.low, 1 - s.high_weight}, {s.high, s.high_weight}})
    for (const auto& [j, wj] : {std::pair{f.low, 1 - f.high_weight}, {f.high, f.high_weight}}) {
      refresh += wi * wj * at(i, j).refresh_hz;
      quality += wi * wj * at(i, j).quality_jnd;
    }
  MarrrBudget b = budget_;
  b.fraction = fraction;
  const double rounded = std::round(refresh);
  return {static_cast<int>(rounded), affordable_reduction(b, rounded), quality};
}

}  // namespace wheatstone
