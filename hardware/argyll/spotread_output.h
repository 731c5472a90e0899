#pragma once
// What ArgyllCMS's spotread prints and writes (docs/hardware/spotread.md).

#include <Eigen/Core>
#include <optional>
#include <string>

#include "hardware/spectroradiometer.h"

namespace wheatstone {

/// Of its line "Result is XYZ: X Y Z, ...", in cd/m^2; nothing if it printed none, or one that is
/// no three finite numbers.
std::optional<Eigen::Vector3d> parse_spotread_xyz(const std::string& output);

/// A spectrum of one reading in CGATS text (SPECTRAL_BANDS, SPECTRAL_START_NM, SPECTRAL_END_NM,
/// SPECTRAL_NORM, one set of data in mW/(sr m^2 nm)), in W/(sr m^2 nm).
/// `what` names the program in errors. Throws DeviceError kProtocol for anything else.
SpectralRadiance parse_cgats_spectrum(const std::string& what, const std::string& text);

}  // namespace wheatstone
