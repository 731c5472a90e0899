#include "rendering/metrics/viewing.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/error.h"

namespace wheatstone {
namespace {

void require_positive(double value, const char* name, const char* remedy) {
  if (!(value > 0) || !std::isfinite(value))
    throw ArgumentError(fmt::format("{} of {} is not positive", name, value), remedy);
}

}  // namespace

LightScale LightScale::of_one(Luminance luminance) {
  require_positive(luminance.value(), "a luminance", "state the cd/m2 that the value 1 stands for");
  return LightScale(luminance.value());
}

RgbImage LightScale::light(RgbImage as_stored) const {
  if (cd_m2_ != 1) as_stored.pixels *= cd_m2_;
  return as_stored;
}

double pixels_per_degree(Length pixel_pitch, Length distance) {
  require_positive(pixel_pitch.value(), "a pixel pitch", "give it in mm");
  require_positive(distance.value(), "a viewing distance", "give it in mm");
  const double pixel_rad = 2 * std::atan(pixel_pitch.value() / (2 * distance.value()));
  return std::numbers::pi / 180 / pixel_rad;
}

double GogDisplay::light_cd_m2(double v) const {
  require_positive(peak_cd_m2, "a display's peak luminance", "state the cd/m2 of full white");
  require_positive(contrast, "a display's contrast", "give peak divided by black, such as 1000");
  require_positive(gamma, "a display's gamma", "give an exponent such as 2.2");
  for (const double reflected : {ambient_lux, reflectivity})
    if (!(reflected >= 0) || !std::isfinite(reflected))
      throw ArgumentError(fmt::format("ambient light of {} lux with reflectivity {} is impossible",
                                      ambient_lux, reflectivity),
                          "give numbers that are not negative");
  const double black = peak_cd_m2 / contrast + ambient_lux / std::numbers::pi * reflectivity;
  if (!(black < peak_cd_m2))
    throw ArgumentError(
        fmt::format("a display with black at {} cd/m2 and white at {} shows nothing", black,
                    peak_cd_m2),
        "check its contrast and the ambient light");
  if (!(v >= 0 && v <= 1))
    throw ArgumentError(fmt::format("a code of {} times full is impossible", v), "give 0 to 1");
  return (peak_cd_m2 - black) * std::pow(v, gamma) + black;
}

}  // namespace wheatstone
