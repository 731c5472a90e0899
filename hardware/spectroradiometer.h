#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/units.h"
#include "hardware/device.h"

namespace wheatstone {

/// Spectral radiance in W/(sr m^2 nm), at first_nm, first_nm + step_nm, ...
struct SpectralRadiance {
  double first_nm = 0, step_nm = 0;
  std::vector<double> values;
};

/// CIE 1931 2 degree XYZ in cd/m^2 (Y is luminance): 683 times the sum of values times the colour
/// matching functions times the step. Throws ArgumentError for fewer than two values, a step that
/// is not in (0, 20] nm, or values that are not numbers.
Eigen::Vector3d xyz_cd_m2(const SpectralRadiance&);

/// Whether a device's own XYZ is that of its spectrum: within 1 % in each part.
bool agree(const Eigen::Vector3d& ours, const Eigen::Vector3d& theirs);

struct SpectralReading {
  SpectralRadiance spectrum;
  Eigen::Vector3d xyz_cd_m2 = Eigen::Vector3d::Zero();  // ours, from the spectrum
  std::optional<Eigen::Vector3d> device_xyz_cd_m2;      // the device's own, agreeing within 1 %
  Duration integration;                                 // 0: the device does not tell
  bool below_floor = false;  // under what the device can measure: the numbers are not light
};

struct SpectroradiometerRange {
  double first_nm = 0, last_nm = 0, step_nm = 0;
  double floor_cd_m2 = 0;
  Duration longest_integration;
};

class Spectroradiometer : public Device {
 public:
  struct Settings {
    Duration longest_integration = Duration::of(60);
    int average = 1;
    Duration synchronise_to;  // period of the light's flicker; 0: none
  };
  virtual SpectroradiometerRange range() const = 0;
  /// Throws kOutOfRange, before anything is sent, for what require_valid() refuses.
  virtual void configure(const Settings&, Deadline) = 0;
  /// Switches the aiming light off first. Throws kTooBright, kTooDark (the device gives no
  /// spectrum), kFault if its own XYZ differs from the spectrum's by more than 1 % above the floor.
  virtual SpectralReading measure(Deadline) = 0;
  /// The aiming light.
  virtual void aim(bool on, Deadline) = 0;
  /// Ends a measurement that is under way; measure() then throws Cancelled.
  virtual void abort() noexcept = 0;
};

/// Throws DeviceError kOutOfRange unless 0 < longest_integration <= `longest`, 1 <= average <= 100
/// and synchronise_to is 0 or 1 ms to 1 s.
void require_valid(const Spectroradiometer::Settings&, Duration longest);

}  // namespace wheatstone
