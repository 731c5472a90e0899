#pragma once
// The LED ceiling of the box: each LED's own colours and strength, and how to light it evenly.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "calib/gain_gamma_offset.h"

namespace wheatstone {

inline constexpr int kLedRows = 16, kLedColumns = 16;

/// One LED with its three emitters (R, G, B). Column c of xyz_cd_m2 is what emitter c adds at full
/// drive beyond what it shows at drive 0, X, Y, Z with Y in cd/m^2; responses[c] says how it rises
/// with the drive, of which only the form counts: (L(d) - L(0)) / (L(1) - L(0)).
/// off_xyz_cd_m2 is what is seen with all emitters at drive 0.
struct LedCalibration {
  Eigen::Matrix3d xyz_cd_m2 = Eigen::Matrix3d::Zero();
  std::array<GainGammaOffset, 3> responses;
  Eigen::Vector3d off_xyz_cd_m2 = Eigen::Vector3d::Zero();
};

/// From readings of one LED: X, Y, Z at full drive of each emitter alone, the same with all off,
/// and a luminance sweep of each emitter. Errors: ArgumentError for emitters of dependent colours,
/// and as fit_gain_gamma_offset().
LedCalibration calibrate_led(const std::array<Eigen::Vector3d, 3>& full_xyz_cd_m2,
                             const Eigen::Vector3d& off_xyz_cd_m2,
                             const std::array<std::vector<DriveReading>, 3>& sweeps);

using LedDrive = std::array<double, 3>;  // of R, G, B, each 0..1

/// Drives with which every LED shows the stated luminance and CIE 1931 chromaticity, its light when
/// off included, in the order of `leds` (row by row).
/// Errors: ArgumentError naming the first LED (row, column) that cannot: a chromaticity outside of
/// its emitters' triangle, or a luminance beyond it or below what its light when off leaves room
/// for, with the range that all LEDs reach.
std::vector<LedDrive> led_drives(const std::vector<LedCalibration>& leds, double luminance_cd_m2,
                                 const Eigen::Vector2d& xy);

/// What an LED adds at given drives to its light when off: X, Y, Z in cd/m^2.
Eigen::Vector3d led_xyz_cd_m2(const LedCalibration&, const LedDrive&);

}  // namespace wheatstone
