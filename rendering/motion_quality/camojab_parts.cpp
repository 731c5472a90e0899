#include "rendering/motion_quality/camojab_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace wheatstone::camojab {
namespace {

/// Lorentzian low-pass at frequencies k * step of a blur `width` wide (eq. 5.9); 1 for width 0.
Eigen::ArrayXd lorentzian(double step_cpd, double width_deg) {
  const Eigen::ArrayXd k = Eigen::ArrayXd::LinSpaced(kCamojabSize, -kHalf, kHalf - 1);
  return 1 / (1 + (4 / std::numbers::pi * width_deg * step_cpd * k).square());
}

void require(bool holds, const std::string& where, const char* what, double value,
             const char* remedy) {
  if (!holds || !std::isfinite(value))
    throw ArgumentError(fmt::format("{}{} of {} is impossible", where, what, value), remedy);
}

}  // namespace

void require_valid(const CamojabConditions& c, const std::string& where) {
  require(c.ppd > 0, where, "ppd", c.ppd, "give pixels per degree above 0");
  require(c.refresh_hz > 0, where, "refresh rate (Hz)", c.refresh_hz, "give one above 0");
  require(c.speed_deg_per_s >= 0, where, "speed (deg/s)", c.speed_deg_per_s,
          "give the magnitude of the velocity, 0 or above");
  require(c.persistence > 0 && c.persistence <= 1, where, "persistence", c.persistence,
          "give the lit part of the frame, above 0 and at most 1");
  require(c.luminance_cd_m2 > 0, where, "luminance (cd/m^2)", c.luminance_cd_m2,
          "give one above 0");
  require(c.mip_level >= 0, where, "mip level", c.mip_level, "give 0 (finest) or above");
  for (const double rate : {c.shading_rate_x, c.shading_rate_y})
    require(rate > 0 && rate <= 1, where, "shading rate", rate,
            "give the part of full resolution, above 0 and at most 1");
}

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
