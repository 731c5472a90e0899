#pragma once
// MARRR: the motion-adaptive refresh rate and resolution model. It compares two displays by how
// blurred and how juddering an object looks that the eye follows.
// Source: thesis (UCAM-CL-TR-977), chapter 3; G. Denes et al., "A perceptual model of motion
// quality for rendering with adaptive refresh-rate and resolution", ACM TOG 39(4), 2020.

#include <span>
#include <vector>

#include "rendering/motion_quality/preset.h"

namespace wheatstone {

/// Whether the observer can foresee where the object goes: the eye follows better if so.
enum class Motion { kPredictable, kUnpredictable };

/// What the model needs to know about a display and what it shows.
struct MarrrDisplay {
  double refresh_hz = 0;
  double ppd = 0;          // pixels per degree, after any reduction of the resolution
  double persistence = 1;  // lit part of the frame, (0, 1]
};

struct MarrrParameters {
  double pursuit_blur_s, pursuit_blur_deg;  // pa, pb: eye blur is persistence * (pa v + pb)
  double judder_threshold;                  // mtj
  std::vector<double> frequencies_cpd;      // over which blur is summed

  /// kPublished differs by pa and pb alone (thesis, table 3.1). The thesis prints the frequencies
  /// as 1, 2, ..., 64; its constants fit octaves, so both presets have the nine octaves 0.25..64.
  static MarrrParameters preset(MotionQualityPreset, Motion);
};

/// How one budget of pixels per second may be spent.
struct MarrrBudget {
  double fraction = 1;  // of full resolution at max_refresh_hz, > 0
  double native_ppd = 2560 / 30.0;
  double persistence = 1;
  int min_refresh_hz = 50, max_refresh_hz = 165;
};

struct MarrrOptimum {
  int refresh_hz = 0;
  double resolution_reduction = 0;  // of width and of height, (0, 1]
  double quality_jnd = 0;           // against full resolution at max_refresh_hz, <= about 0
};

/// Errors of all members: ArgumentError for a negative speed or sigma, a refresh rate, ppd or
/// fraction that is not positive, a persistence outside (0, 1], non-finite numbers.
class Marrr {
 public:
  explicit Marrr(MotionQualityPreset = MotionQualityPreset::kReleased,
                 Motion = Motion::kPredictable);
  explicit Marrr(MarrrParameters);

  /// Energy of what a Gaussian blur leaves visible (thesis, eq. 3.8); the larger, the sharper.
  double blur_energy(double sigma_deg) const;
  /// Energy of the aliases that a refresh rate adds to motion (eq. 3.10); the larger, the worse.
  double judder_energy(double refresh_hz, double speed_deg_per_s) const;
  /// The quality of `a` above that of `b` in JND (eq. 3.12, its judder term with the opposite sign,
  /// as it was fitted).
  double quality_difference_jnd(const MarrrDisplay& a, const MarrrDisplay& b,
                                double speed_deg_per_s) const;

  /// Quality of a refresh rate under the budget, with as many pixels as it leaves to each frame.
  MarrrOptimum spend(const MarrrBudget&, int refresh_hz, double speed_deg_per_s) const;
  /// The best integer refresh rate; the lowest of equals (section 3.3).
  MarrrOptimum optimum(const MarrrBudget&, double speed_deg_per_s) const;

 private:
  double blur_quality(const MarrrDisplay&, double speed_deg_per_s) const;

  MarrrParameters parameters_;
  std::vector<double> sensitivities_;  // at frequencies_cpd, over their threshold
};

/// The integer frequency in 1..50 cpd to which Kelly's sensitivity at this rate is largest.
int judder_peak_cpd(double refresh_hz);

/// Optima over a grid of speeds and budgets, computed once, for use per frame.
class MarrrTable {
 public:
  /// Speeds and fractions each ascending and distinct; `budget.fraction` is replaced by each of
  /// the fractions. Computed in parallel. Errors: ArgumentError, also for an empty or unsorted
  /// axis.
  MarrrTable(const Marrr&, std::vector<double> speeds_deg_per_s, std::vector<double> fractions,
             MarrrBudget budget = {});

  std::span<const double> speeds_deg_per_s() const { return speeds_; }
  std::span<const double> fractions() const { return fractions_; }
  const MarrrOptimum& at(std::size_t speed, std::size_t fraction) const;

  /// Refresh rate interpolated bilinearly and rounded to 1 Hz, the resolution then as the budget
  /// allows; outside the grid as at its border. quality_jnd is interpolated.
  /// Errors: ArgumentError for a negative or non-finite speed, a fraction that is not positive.
  MarrrOptimum lookup(double speed_deg_per_s, double fraction) const;

 private:
  std::vector<double> speeds_, fractions_;
  MarrrBudget budget_;
  std::vector<MarrrOptimum> optima_;  // [speed][fraction]
};

}  // namespace wheatstone
