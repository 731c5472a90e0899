#pragma once
// The response of a display or lamp channel to its drive (hdr_merge.md, sec. 7).

#include <vector>

namespace wheatstone {

/// L(d) = span max(gain d + offset, 0)^gamma + black, d in 0..1, with gain = 1 - offset, so that
/// L(1) = span + black.
struct GainGammaOffset {
  double span_cd_m2 = 0, offset = 0, gamma = 1, black_cd_m2 = 0;

  double gain() const { return 1 - offset; }
  double luminance_cd_m2(double drive) const;
  /// The drive for a luminance, clamped to 0..1 for light the channel cannot give.
  double drive(double luminance_cd_m2) const;
};

struct DriveReading {
  double drive = 0, luminance_cd_m2 = 0;
};

struct GainGammaOffsetFit {
  GainGammaOffset response;
  double relative_rms = 0;  // of (fit - measured) / max(measured, 0.001 cd/m^2)
};

/// Least squares of relative residuals, so that dark steps count as much as bright ones.
/// Errors: ArgumentError for fewer than five readings or three different drives, a drive outside
/// 0..1, a luminance that is negative or not finite, and readings that do not rise with the drive.
GainGammaOffsetFit fit_gain_gamma_offset(const std::vector<DriveReading>&);

}  // namespace wheatstone
