#pragma once
// Contrast sensitivity functions of the motion-quality models. All take spatial frequency in
// cycles per degree (cpd), temporal frequency in Hz, retinal velocity in deg/s and luminance in
// cd/m^2, and return sensitivity, the inverse of the contrast at threshold.
// Errors, all functions: ArgumentError for a negative or non-finite frequency or velocity, a
// luminance or field that is not positive.

#include <array>

namespace wheatstone {

/// Spatial sensitivity for a square field of `field_deg` at the given luminance; 0 at 0 cpd.
/// Source: P. Barten, "Formula for the contrast sensitivity of the human eye", 2004, as MARRR uses
/// it (thesis, section 3.2).
double barten_csf(double rho_cpd, double luminance_cd_m2, double field_deg);

/// Spatio-temporal sensitivity as MARRR uses it: D. Kelly's (1979) surface without its factors 2
/// pi, because MARRR's thresholds were fitted with this form. 0 at 0 cpd (its limit).
double kelly_csf(double rho_cpd, double omega_hz);

/// Sensitivity D to a pattern that moves over the retina; eye drift keeps the velocity at 0.3 deg/s
/// or above. 0 at 0 cpd. Source: J. Laird et al., "Spatio-velocity CSF as a function of retinal
/// velocity using unstabilized stimuli", 2006, after S. Daly, 1998.
double velocity_csf(double rho_cpd, double velocity_deg_per_s);

/// Sensitivity S0 to a static luminance modulation around D65 within a disc of 0.2 deg radius; 0 at
/// 0 cpd. Three post-receptoral mechanisms, reduced to one direction of colour. Source: thesis,
/// section 5.2; R. Mantiuk et al., "Practical color contrast sensitivity functions for luminance
/// levels up to 10000 cd/m^2", 2020.
class StaticCsf {
 public:
  explicit StaticCsf(double luminance_cd_m2);
  double operator()(double rho_cpd) const;

 private:
  struct Mechanism {
    double gain, peak_cpd, log_peak_cpd, fall, area, critical_area;
    bool low_pass;  // no fall below the peak
  };
  std::array<Mechanism, 3> mechanisms_;
};
inline double static_csf(double rho_cpd, double luminance_cd_m2) {
  return StaticCsf(luminance_cd_m2)(rho_cpd);
}

/// Temporal part: D(rho, omega / rho) / (D(rho, 0) + 1e-5). 0 at 0 cpd and 0 Hz; at 0 cpd and
/// omega > 0 the velocity is infinite and the ratio undefined: NaN.
double velocity_csf_ratio(double rho_cpd, double omega_hz);

/// S = S0 * temporal part, with the temporal part's values at 0 cpd. Source: thesis, eq. 5.4.
inline double spatiotemporal_csf(double rho_cpd, double omega_hz, double luminance_cd_m2) {
  return static_csf(rho_cpd, luminance_cd_m2) * velocity_csf_ratio(rho_cpd, omega_hz);
}

}  // namespace wheatstone
