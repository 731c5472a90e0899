#pragma once
// The steps of CaMoJAB that its fast and its plain evaluation share. k is a bin, -256..255.

#include <vector>

#include "rendering/motion_quality/camojab.h"
#include "rendering/motion_quality/contrast_sensitivity.h"

namespace wheatstone::camojab {

inline constexpr int kHalf = kCamojabSize / 2;

/// Gain of every column or row k when a texture is sampled through its mip level at a coarse rate
/// (thesis, eq. 5.8). It does not depend on ppd: the blur grows as the bins narrow.
Eigen::ArrayXd mip_gain(const CamojabModel&, double mip_level, double smaller_rate);

/// Gain of every column k by eye motion and hold-type blur (eq. 5.16, 5.17).
Eigen::ArrayXd motion_gain(const CamojabModel&, const CamojabConditions&);

/// A spectrum sampled at `rate` is the sum of its copies shifted by these numbers of bins:
/// out[k] = sum of in[k + offset], 0 outside (eq. 5.11, or the released program's version of it).
std::vector<int> replica_offsets(const CamojabModel&, double rate);

/// The largest |k| that `rate` retains (eq. 5.13); decided on integers.
int retained_bins(const CamojabModel&, double rate);

/// By how many columns motion shifts its first alias (eq. 5.22); at most 1e9, far outside.
int alias_shift_bins(const CamojabModel&, const CamojabConditions&);

/// Radial frequency of bin (kx, ky), in bins.
double radius_bins(const CamojabModel&, int kx, int ky);

/// S(rho, omega, L) of the bin at this radius, and 1 where that is undefined (0 cpd, above 0 Hz).
double sensitivity(double radius_bins, double omega_hz, const CamojabConditions&, const StaticCsf&);

CamojabQuality quality(const CamojabWeights&, double spatial_distortion,
                       double temporal_distortion);

}  // namespace wheatstone::camojab
