#include "rendering/motion_quality/camojab_parts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace wheatstone::camojab {
namespace {

/// Lorentzian low-pass at frequencies k * step of a blur `width` wide (eq. 5.9); 1 for width 0.
Eigen::ArrayXd lorentzian(double step_cpd, double width_deg) {
  const Eigen::ArrayXd k = Eigen::ArrayXd::LinSpaced(kCamojabSize, -kHalf, kHalf - 1);
  return 1 / (1 + (4 / std::numbers::pi * width_deg * step_cpd * k).square());
}

}  // namespace

Eigen::ArrayXd mip_gain(const CamojabModel& model, double mip_level, double smaller_rate) {
  const double width_px = model.mip_blur ? std::exp2(mip_level) / smaller_rate : 0;
  return lorentzian(1.0 / kCamojabSize, width_px);
}

Eigen::ArrayXd motion_gain(const CamojabModel& model, const CamojabConditions& c) {
  const double hold_deg = model.hold_blur ? c.persistence * c.speed_deg_per_s / c.refresh_hz : 0;
  const double eye_deg =
      model.eye_blur ? c.persistence * (0.001648 * c.speed_deg_per_s + 0.079818) : 0;
  const double step_cpd = c.ppd / kCamojabSize;
  return lorentzian(step_cpd, hold_deg) * lorentzian(step_cpd, eye_deg);
}

std::vector<int> replica_offsets(const CamojabModel& model, double rate) {
  if (!model.aliasing) return {0};
  if (model.comb == CamojabModel::Comb::kHalfIntervalOneSide) {
    // The released program convolves with a comb of m bins; centring an even one shifts it by one.
    const int m = static_cast<int>(std::floor(kCamojabSize * rate + 1.5));
    return m % 2 ? std::vector{0, (m - 1) / 2} : std::vector{1, m / 2};
  }
  const int interval = static_cast<int>(std::floor(kCamojabSize * rate + 0.5));
  if (model.comb == CamojabModel::Comb::kFullIntervalOneSide) return {0, interval};
  return {0, interval, -interval};
}

int retained_bins(const CamojabModel& model, double rate) {
  return model.clipping ? static_cast<int>(std::floor(kHalf * rate + 1e-9)) : kHalf;
}

int alias_shift_bins(const CamojabModel& model, const CamojabConditions& c) {
  const double step_cpd = c.ppd / kCamojabSize;
  const double alias_cpd = model.alias_position * c.refresh_hz / std::max(c.speed_deg_per_s, 0.1);
  return static_cast<int>(std::min(std::floor(alias_cpd / step_cpd), 1e9));
}

double radius_bins(const CamojabModel& model, int kx, int ky) {
  return model.radius == CamojabModel::Radius::kEuclidean ? std::hypot(kx, ky)
                                                          : std::max(std::abs(kx), std::abs(ky));
}

double sensitivity(double radius_bins, double omega_hz, const CamojabConditions& c,
                   const StaticCsf& static_csf) {
  const double rho_cpd = radius_bins * c.ppd / kCamojabSize;
  return rho_cpd == 0 && omega_hz > 0 ? 1
                                      : static_csf(rho_cpd) * velocity_csf_ratio(rho_cpd, omega_hz);
}

CamojabQuality quality(const CamojabWeights& weights, double spatial_distortion,
                       double temporal_distortion) {
  return {spatial_distortion, temporal_distortion,
          weights.spatial * spatial_distortion + weights.temporal * temporal_distortion};
}

}  // namespace wheatstone::camojab
