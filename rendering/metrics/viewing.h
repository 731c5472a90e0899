#pragma once
// What stands between a picture's numbers and light at the eye. Metrics take RgbImage, which is
// always cd/m^2; these are the ways to make one of numbers that are not, so that no score is ever
// computed on relative values.

#include "core/image.h"
#include "core/units.h"

namespace wheatstone {

/// What one unit of a linear picture is. There is no default: a picture without a stated scale
/// cannot be scored.
class LightScale {
 public:
  /// R = G = B = 1 is white of this luminance. Errors: ArgumentError unless positive and finite.
  static LightScale of_one(Luminance);
  /// The numbers are cd/m^2 already.
  static LightScale absolute() { return of_one(Luminance::of(1)); }

  /// In place.
  RgbImage light(RgbImage as_stored) const;

 private:
  explicit LightScale(double cd_m2) : cd_m2_(cd_m2) {}
  double cd_m2_;
};

/// Pixels per degree where the line of sight meets the display at a right angle: 1 over the angle
/// of one pixel there, 2 atan(pitch / (2 distance)). Errors: ArgumentError unless both are positive
/// and finite.
double pixels_per_degree(Length pixel_pitch, Length distance);

/// Gain-gamma-offset model of a display, for integer pictures (SDR), channel by channel:
///   L = (L_peak - L_black) V^gamma + L_black,  V = 0..1 the fraction of the full code,
///   L_black = L_peak / contrast + E_ambient / pi * reflectivity.
/// Source: reference metrics.md, section 2.
struct GogDisplay {
  double peak_cd_m2 = 0;  // no default: must be stated
  double contrast = 1000;
  double gamma = 2.2;
  double ambient_lux = 0;
  double reflectivity = 0.005;

  /// Errors: ArgumentError naming the parameter that is not positive and finite (ambient_lux and
  /// reflectivity may be 0), a peak not above black, or V outside 0..1.
  double light_cd_m2(double v) const;
};

}  // namespace wheatstone
