#pragma once
// Veiling glare of the lens, taken out by inverting its modulation transfer function.

#include <filesystem>

#include "core/image.h"

namespace wheatstone {

/// MTF(rho) = a1 exp(-((rho - b1) / c1)^2) + a2 exp(-((rho - b2) / c2)^2), rho in half cycles per
/// pixel of one colour plane of the mosaic (0.25 at its Nyquist frequency along a row).
struct GlareMtf {
  double a1 = 1, b1 = 0, c1 = 1, a2 = 0, b2 = 0, c2 = 1;
};

/// A TOML file (docs/hdr_merge.md): schema "wheatstone-glare/1", lens, and the six numbers by name.
/// Errors: FileError naming line and key.
GlareMtf read_glare_mtf(const std::filesystem::path&);

/// Divides the spectrum of each of the four colour planes by the MTF and takes the modulus of what
/// comes back. Same unit; never negative. Strong glare corrections amplify noise. Any size of at
/// least 2 x 2; in planes of odd size the frequency grid ends at 0.5 exactly, as the reference has
/// it (hdr_merge.md, sec. 4).
/// Errors: ArgumentError for an MTF that is not 1 (within 0.001) at rho = 0 or below 0.05 somewhere
/// over the plane, and for less than one cell.
LinearMosaic remove_glare(const LinearMosaic&, const GlareMtf&);

}  // namespace wheatstone
