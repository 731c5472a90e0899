#pragma once
// The CIE 1931 standard colorimetric observer (2 degrees).

#include <Eigen/Core>

namespace wheatstone {

inline constexpr double kFirstVisibleNm = 360, kLastVisibleNm = 830;

/// Colour matching functions x, y, z at a wavelength: the CIE's values each 5 nm (ISO/CIE
/// 11664-1:2019, as tabulated by cvrl.org, ciexyz31), linear in between, 0 beyond 360 to 830 nm.
Eigen::Vector3d cie_1931_colour_matching(double nm);

}  // namespace wheatstone
