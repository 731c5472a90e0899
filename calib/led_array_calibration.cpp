#include "calib/led_array_calibration.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "core/colour.h"
#include "core/error.h"

namespace wheatstone {
namespace {

std::string led_name(std::size_t i) {
  return "LED at row " + std::to_string(i / kLedColumns) + ", column " +
         std::to_string(i % kLedColumns);
}

}  // namespace

LedCalibration calibrate_led(const std::array<Eigen::Vector3d, 3>& full_xyz_cd_m2,
                             const Eigen::Vector3d& off_xyz_cd_m2,
                             const std::array<std::vector<DriveReading>, 3>& sweeps) {
  LedCalibration out;
  for (std::size_t c = 0; c < 3; ++c) {
    out.xyz_cd_m2.col(static_cast<Eigen::Index>(c)) = full_xyz_cd_m2[c] - off_xyz_cd_m2;
    out.responses[c] = fit_gain_gamma_offset(sweeps[c]).response;
  }
  out.off_xyz_cd_m2 = off_xyz_cd_m2;
  if (!out.xyz_cd_m2.allFinite() ||
      !Eigen::FullPivLU<Eigen::Matrix3d>(out.xyz_cd_m2).isInvertible())
    throw ArgumentError("the three emitters of an LED do not have three colours",
                        "measure each of them alone at full drive");
  return out;
}

Eigen::Vector3d led_xyz_cd_m2(const LedCalibration& led, const LedDrive& drive) {
  Eigen::Vector3d level;
  for (std::size_t c = 0; c < 3; ++c) {
    const GainGammaOffset& r = led.responses[c];
    const double off = r.luminance_cd_m2(0);
    level[static_cast<Eigen::Index>(c)] =
        (r.luminance_cd_m2(drive[c]) - off) / (r.luminance_cd_m2(1) - off);
  }
  return led.xyz_cd_m2 * level;
}

std::vector<LedDrive> led_drives(const std::vector<LedCalibration>& leds, double luminance_cd_m2,
                                 const Eigen::Vector2d& xy) {
  if (!(luminance_cd_m2 >= 0) || !std::isfinite(luminance_cd_m2)) {
    std::ostringstream problem;
    problem << "a luminance of " << luminance_cd_m2 << " cd/m^2";
    throw ArgumentError(problem.str(), "give 0 or more");
  }
  const Eigen::Vector3d unit_xyz = xyz_from_xyY(xy, 1);
  std::vector<Eigen::Vector3d> levels, off_levels;  // per cd/m^2, and of the light when off
  double highest_cd_m2 = std::numeric_limits<double>::infinity(), lowest_cd_m2 = 0;
  std::size_t weakest = 0, brightest_off = 0;
  for (std::size_t i = 0; i < leds.size(); ++i) {
    const Eigen::FullPivLU<Eigen::Matrix3d> lu(leds[i].xyz_cd_m2);
    if (!lu.isInvertible())
      throw ArgumentError("the " + led_name(i) + " is not calibrated", "measure its emitters");
    levels.push_back(lu.solve(unit_xyz));
    off_levels.push_back(lu.solve(leds[i].off_xyz_cd_m2));
    // A colour on the edge of the triangle needs none of one emitter, up to rounding.
    const double rounding = 1e-12 * levels[i].maxCoeff();
    if (levels[i].minCoeff() < -rounding) {
      std::ostringstream problem;
      problem << "the " << led_name(i) << " cannot show the chromaticity (" << xy.x() << ", "
              << xy.y() << ")";
      throw ArgumentError(problem.str(), "choose one inside of its emitters' triangle");
    }
    // An emitter's level at L cd/m^2 is level L - off_level, and must lie in 0..1.
    for (int c = 0; c < 3; ++c) {
      const double level = levels[i][c], off = off_levels[i][c];
      if (level > rounding && (1 + off) / level < highest_cd_m2) {
        highest_cd_m2 = (1 + off) / level;
        weakest = i;
      }
      if (off > 1e-12 && off / std::max(level, rounding) > lowest_cd_m2) {
        lowest_cd_m2 = off / std::max(level, rounding);
        brightest_off = i;
      }
    }
  }
  if (lowest_cd_m2 > highest_cd_m2) {
    std::ostringstream problem;
    problem << "the " << led_name(brightest_off) << " shows too much light when off for (" << xy.x()
            << ", " << xy.y() << ") at any luminance";
    throw ArgumentError(problem.str(), "darken the room, or choose another chromaticity");
  }
  const bool too_dark = luminance_cd_m2 < lowest_cd_m2 * (1 - 1e-12);
  if (too_dark || luminance_cd_m2 > highest_cd_m2 * (1 + 1e-12)) {
    std::ostringstream problem;
    problem << "the " << led_name(too_dark ? brightest_off : weakest) << " cannot show "
            << (too_dark ? "as little as " : "") << luminance_cd_m2 << " cd/m^2"
            << (too_dark ? " beside its light when off" : "");
    std::ostringstream remedy;
    remedy << "ask for " << lowest_cd_m2 << " to " << highest_cd_m2
           << " cd/m^2 at this chromaticity";
    throw ArgumentError(problem.str(), remedy.str());
  }
  std::vector<LedDrive> out(leds.size());
  for (std::size_t i = 0; i < leds.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const GainGammaOffset& r = leds[i].responses[c];
      const auto e = static_cast<Eigen::Index>(c);
      const double level = luminance_cd_m2 * levels[i][e] - off_levels[i][e];
      const double off = r.luminance_cd_m2(0);
      // Off is off, also where the response begins above drive 0.
      out[i][c] = level > 0 ? r.drive(off + (r.luminance_cd_m2(1) - off) * level) : 0;
    }
  return out;
}

}  // namespace wheatstone
