#pragma once
// What the eye's optics do to light: glare and the pupil.
// Source: HDR-VDP-3 (reference metrics.md, section 4, steps 1 and 4); pupil: Watson and Yellott,
// "A unified formula for light-adapted pupil size", Journal of Vision 12(10), 2012.

#include <opencv2/core.hpp>

namespace wheatstone {

/// Modulation transfer function of the eye, 1 at 0 cpd; rho_cpd >= 0.
double eye_mtf(double rho_cpd);

/// Applies the eye's modulation transfer function to planes of one size. Beyond its borders a
/// plane goes on as its mirror image, edge sample repeated.
class EyeGlare {
 public:
  EyeGlare(cv::Size, double pixels_per_degree);
  /// Replaces any linear light by what reaches the retina, which may be slightly negative beside
  /// very bright spots. Pre: plane.size() is the constructor's.
  void apply(cv::Mat1d& plane) const;

 private:
  cv::Mat1d gain_;  // of each coefficient of the cosine transform
};

/// Pupil diameter, mm, of an observer adapted to `luminance_cd_m2` over `area_deg2`.
/// Stanley-Davies for age 28.58, unified formula for others; age clamped to 20..83.
double pupil_diameter_mm(double luminance_cd_m2, double area_deg2, double age_years);

}  // namespace wheatstone
