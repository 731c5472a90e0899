#pragma once
// The noise of a sensor from pairs of equal frames of an even surface (photon transfer).

#include <array>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/rig_types.h"

namespace wheatstone {

/// Two frames of the same light, exposure and gain; any evenness of illumination will do, since
/// only their difference is used.
struct FlatPair {
  MosaicImage a, b;
  double gain = 1;  // ISO / 100
};

struct PhotonTransfer {
  SensorNoise noise, sigma;  // sigma: standard deviation of each parameter
  /// False when all pairs have one gain: noise before and after the amplifier then cannot be told
  /// apart, read_noise_e is 0, and adc_noise holds both, for that gain.
  bool separated = false;
  double chi2_per_measurement = 0;  // near 1 where the model holds
};

/// Least squares of the pairs' variances of each colour, weighted by their own precision, less
/// the 1/12 DN^2 of whole codes. Pairs should span dark frames to near saturation.
/// Errors: ArgumentError naming the pair for frames that disagree, saturated pixels or a gain that
/// is not positive; for fewer than three pairs, and for light that is the same in all.
/// Source: J. R. Janesick, "Photon Transfer" (SPIE Press 2007); reference hdr_merge.md, sec. 1.
PhotonTransfer measure_sensor_noise(const std::vector<FlatPair>&,
                                    const std::array<double, 4>& black_dn, int saturation_dn);

}  // namespace wheatstone
