#pragma once
// HDR-VDP-3, task "quality": how different two pictures look to one observer, from light on the
// screen through the eye's optics, receptors and contrast-sensitive channels to one score.
// Source: Mantiuk, Hammou, Hanji, "HDR-VDP-3" (arXiv:2304.13625), and Mantiuk et al., SIGGRAPH
// 2011, with the constants of HDR-VDP 3.0.7; reference metrics.md, section 4.
//
// Only luminance differences count: a change of colour at equal cone and rod response is not seen.

#include "core/image.h"

namespace wheatstone {

/// Emission of the display that R, G and B are shown on; it decides what cones and rods receive.
enum class DisplaySpectra {
  kLedLcdSrgb,  // LCD with white LEDs, BT.709 primaries
  kLedLcdWcg,   // LCD with a wide gamut
  kOled
};

/// The pupil's and the lens's age. The published receptor matrices hold this age's lens only, so
/// no other can be asked for.
inline constexpr double kHdrVdp3ObserverAgeYears = 24;

inline constexpr double kHdrVdp3MinPixelsPerDegree = 4, kHdrVdp3MaxPixelsPerDegree = 400;
inline constexpr int kHdrVdp3MinSidePx = 13;  // the pyramid's largest filter

struct HdrVdp3Options {
  double pixels_per_degree = 0;  // of visual angle; has to be given
  double observer_age_years = kHdrVdp3ObserverAgeYears;
  DisplaySpectra spectra = DisplaySpectra::kLedLcdSrgb;
};

struct HdrVdp3Result {
  double q_jod = 10;  // just-objectionable differences; 10 = no difference, 1 JOD lower = 75 % of
                      // observers prefer the reference. Falls below 0 for absurd differences.
  double q = 10;      // the same before the mapping to JOD; 10 = no difference
  double q_err = 0;   // the pooled difference, threshold units, >= 0
  double p_det = 0;   // probability that an observer notices any difference, 0..1
  double c_max = 0;   // the largest local visible contrast, in thresholds (1 = seen half the time)
  ScalarImage detection_probability;  // of a difference at this place, 0..1, size of the images
};

/// Scores `test` against `reference`, both absolute linear light. Deterministic for every number
/// of threads. Time grows with the number of pixels; a side with a large prime factor is slower.
/// Errors: ArgumentError for sizes that differ, a side below 13 px, NaN/infinite/negative light,
/// an image that is black everywhere, pixels per degree outside 4..400, an age other than 24.
HdrVdp3Result hdr_vdp3(const RgbImage& test, const RgbImage& reference, const HdrVdp3Options&);

}  // namespace wheatstone
