#include "rendering/motion_quality/contrast_sensitivity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.h"

namespace wheatstone {
namespace {

using std::numbers::pi;

void require_not_negative(double value, const char* name, const char* unit) {
  if (!(value >= 0) || !std::isfinite(value))
    throw ArgumentError(fmt::format("{} of {} {} is not a number >= 0", name, value, unit),
                        "give a finite one that is not negative");
}

void require_positive(double value, const char* name, const char* unit) {
  if (!(value > 0) || !std::isfinite(value))
    throw ArgumentError(fmt::format("{} of {} {} is not positive", name, value, unit),
                        "give a finite one above 0");
}

/// Velocity-dependent height of Kelly's surface.
double kelly_peak(double velocity_deg_per_s) {
  const double decades = std::abs(std::log10(velocity_deg_per_s / 3));
  return 6.1 + 7.3 * decades * decades * decades;
}

/// Growth with luminance y: a (1 + b / y)^-c.
struct Saturation {
  double a, b, c;
  double operator()(double y) const { return a * std::pow(1 + b / y, -c); }
};

/// One mechanism of the static sensitivity, as fitted.
struct MechanismFit {
  Saturation peak;              // sensitivity at the peak
  double decline_d, decline_e;  // the peak falls again in bright light; decline_e 0: it does not
  Saturation peak_cpd;          // c = 0: constant
  double bandwidth, gamma, critical_area;
  bool low_pass;
  double gain;  // for luminance modulation around D65
};

constexpr std::array<MechanismFit, 3> kMechanisms = {{
    {{346170, 5.64888, 0.319293},
     1.8663e6,
     7.57549e-5,
     {2.12365, 2289.53, 0.186249},
     1.09076,
     1.11387,
     52.3184,
     false,
     1.212845487585724},
    {{439.738, 22.4193, 0.479041},
     0,
     0,
     {0.119941, 0, 0},
     2.70798,
     1.73378,
     1.25741,
     true,
     0.0648038367785897},
    {{11867.2, 253.395, 0.33456},
     0,
     0,
     {7.74728e-8, 0, 0},
     5.33398,
     1.47414,
     0.28267,
     true,
     0.15061206641936747},
}};

constexpr double kStaticArea_deg2 = pi * 0.2 * 0.2;
constexpr double kMechanismLuminancePerCdM2 = 1.0510237326125584;  // L + M of D65 at 1 cd/m^2

}  // namespace

double barten_csf(double rho_cpd, double luminance_cd_m2, double field_deg) {
  require_not_negative(rho_cpd, "a spatial frequency", "cpd");
  require_positive(luminance_cd_m2, "a luminance", "cd/m^2");
  require_positive(field_deg, "a field", "deg");
  const double u2 = rho_cpd * rho_cpd;
  const double optics = 5200 * std::exp(-0.0016 * u2 * std::pow(1 + 100 / luminance_cd_m2, 0.08));
  const double area = 1 + 144 / (field_deg * field_deg) + 0.64 * u2;
  const double noise = 63 / std::pow(luminance_cd_m2, 0.83) + 1 / -std::expm1(-0.02 * u2);
  return optics / std::sqrt(area * noise);
}

double kelly_csf(double rho_cpd, double omega_hz) {
  require_not_negative(rho_cpd, "a spatial frequency", "cpd");
  require_not_negative(omega_hz, "a temporal frequency", "Hz");
  if (rho_cpd == 0) return 0;
  const double velocity = std::max(omega_hz / rho_cpd, 0.01);
  const double highest_cpd = 45.9 / (velocity + 2);
  return kelly_peak(velocity) * velocity * rho_cpd * rho_cpd * std::exp(-2 * rho_cpd / highest_cpd);
}

double velocity_csf(double rho_cpd, double velocity_deg_per_s) {
  require_not_negative(rho_cpd, "a spatial frequency", "cpd");
  require_not_negative(velocity_deg_per_s, "a velocity", "deg/s");
  constexpr double c0 = 0.6329, c1 = 0.8404, c2 = 0.7986;
  const double velocity = c2 * std::max(velocity_deg_per_s, 0.3);
  const double highest_cpd = 45.9 / (velocity + 2);
  const double angular = 2 * pi * c1 * rho_cpd;
  return kelly_peak(velocity) * c0 * c1 * velocity * angular * angular *
         std::exp(-2 * angular / highest_cpd);
}

StaticCsf::StaticCsf(double luminance_cd_m2) {
  require_positive(luminance_cd_m2, "a luminance", "cd/m^2");
  const double y = kMechanismLuminancePerCdM2 * luminance_cd_m2;
  for (std::size_t i = 0; i < mechanisms_.size(); ++i) {
    const MechanismFit& fit = kMechanisms[i];
    double peak = fit.peak(y);
    if (fit.decline_e > 0) peak *= 1 - std::pow(1 + fit.decline_d / y, -fit.decline_e);
    const double peak_cpd = fit.peak_cpd(y);
    mechanisms_[i] = {fit.gain * peak,
                      peak_cpd,
                      std::log10(peak_cpd),
                      std::numbers::ln10 / (0.5 * std::exp2(fit.bandwidth)),
                      std::pow(kStaticArea_deg2, fit.gamma),
                      fit.critical_area + 0.65 * kStaticArea_deg2,
                      fit.low_pass};
  }
}

double StaticCsf::operator()(double rho_cpd) const {
  require_not_negative(rho_cpd, "a spatial frequency", "cpd");
  if (rho_cpd == 0) return 0;
  const double log_cpd = std::log10(rho_cpd);
  double sum = 0;
  for (const Mechanism& m : mechanisms_) {
    const double decades = log_cpd - m.log_peak_cpd;
    const double height =
        m.low_pass && rho_cpd < m.peak_cpd ? 1 : std::exp(-m.fall * decades * decades);
    const double cycles = m.area * rho_cpd * rho_cpd;
    sum += m.gain * m.gain * height * height * cycles / (m.critical_area + cycles);
  }
  return std::sqrt(sum);
}

double velocity_csf_ratio(double rho_cpd, double omega_hz) {
  require_not_negative(rho_cpd, "a spatial frequency", "cpd");
  require_not_negative(omega_hz, "a temporal frequency", "Hz");
  if (rho_cpd == 0) return omega_hz == 0 ? 0 : std::numeric_limits<double>::quiet_NaN();
  return velocity_csf(rho_cpd, omega_hz / rho_cpd) / (velocity_csf(rho_cpd, 0) + 1e-5);
}

}  // namespace wheatstone
