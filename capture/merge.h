#pragma once
// One linear mosaic from an exposure stack (reference hdr_merge.md, sec. 1 and 2).

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>

#include "core/image.h"
#include "core/rig_types.h"
#include "core/units.h"

namespace wheatstone {

/// One raw frame of a stack.
struct RawExposure {
  MosaicImage frame;
  Duration exposure;
  double gain = 1;           // g, ISO / 100
  double aperture_area = 1;  // A, light collected relative to the other frames

  /// What a given light makes of it, relative to 1 s at ISO 100.
  double scale_s() const { return exposure.value() * gain * aperture_area; }
};

/// kPoisson: the maximum-likelihood estimate when photon noise dominates,
///   phi = sum_i (y_i - black) / (g_i A_i) / sum_i t_i; needs no noise parameters.
/// kFullNoise: inverse-variance weights (t g A)^2 / Var(y) with the whole noise model at the
///   previous estimate; ten iterations from the Poisson estimate. Differs in deep shadows only.
enum class MergeEstimator { kPoisson, kFullNoise };
std::string to_string(MergeEstimator);                           // "poisson", "full"
MergeEstimator merge_estimator_from_string(const std::string&);  // throws ArgumentError

struct MergeOptions {
  MergeEstimator estimator = MergeEstimator::kPoisson;
  std::array<double, 4> black_dn = {0, 0, 0, 0};  // at (0,0), (0,1), (1,0), (1,1) of each cell
  int saturation_dn = 65535;                      // the first saturated code
  std::optional<SensorNoise> noise;               // needed for kFullNoise and for deviations
};
MergeOptions merge_options(const CameraProfile&);

/// Bits of MergedMosaic::flags.
inline constexpr std::uint8_t kSaturated = 1;     // even in the shortest exposure: a lower bound
inline constexpr std::uint8_t kUnderexposed = 2;  // below two standard deviations
inline constexpr std::uint8_t kSingleSource = 4;  // measured by one frame only

struct MergedMosaic {
  LinearMosaic mosaic;   // phi, DN/s at ISO 100, black level subtracted; may be negative
  cv::Mat1f sigma_dn_s;  // its standard deviation, same size; empty without noise parameters
  cv::Mat1b flags;       // bits above, same size; kUnderexposed needs noise parameters
};

/// Merges over the frames in which the pixel's whole 2x2 cell is strictly below saturation, and
/// always over the shortest one (least t g A). Half cells at the edge of odd sizes decide alone.
/// Nothing is normalised and nothing is clipped. The order of the frames does not matter.
/// Errors: ArgumentError, naming the frame's index, for sizes or patterns that disagree, for times,
/// gains or areas that are not positive, and for two frames of the same exposure; for an empty
/// stack, a black level that is not below saturation, noise parameters that are negative, not
/// finite, or missing for kFullNoise.
MergedMosaic merge_exposures(std::span<const RawExposure>, const MergeOptions&);

/// The same into `out`, whose memory is used again if it has the right size.
void merge_exposures(std::span<const RawExposure>, const MergeOptions&, MergedMosaic& out);

/// Throws what merge_exposures() would throw, without merging.
void check_exposures(std::span<const RawExposure>, const MergeOptions&);

}  // namespace wheatstone
