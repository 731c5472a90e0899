#pragma once
// Perceptually uniform encoding of absolute luminance (PU21) and peak signal-to-noise ratios.
// Source: Mantiuk and Azimi, "PU21: A novel perceptually uniform encoding for adapting existing
// quality metrics for HDR", PCS 2021; reference metrics.md, section 1.

#include <span>

#include "core/image.h"

namespace wheatstone {

enum class Pu21Variant { kBanding, kBandingGlare, kPeaks, kPeaksGlare };
std::string to_string(Pu21Variant);                        // "banding_glare", ...
Pu21Variant pu21_variant_from_string(const std::string&);  // throws ArgumentError

inline constexpr double kPu21MinCdM2 = 0.005, kPu21MaxCdM2 = 10000;
/// The peak of every score on PU values, whatever the display's peak: 100 cd/m^2 is about 256.
inline constexpr double kPu21Peak = 256;

/// cd/m^2, clamped to 0.005..10000, to PU21 units (about 0..595).
double pu21_encode(double luminance_cd_m2, Pu21Variant = Pu21Variant::kBandingGlare);
/// The inverse; pu21_decode(0) is about 0.005 cd/m^2, not exactly.
double pu21_decode(double pu21, Pu21Variant = Pu21Variant::kBandingGlare);

/// The same for whole images, vectorised, on the calling thread. Within 1e-6 (PU21 units) plus 1e-6
/// of the value of the function above, also where the curve reaches 0 and at both clamps; the same
/// bits on every processor.
/// Errors: ArgumentError for lengths that differ; NaN, infinite or negative light (the first place
/// and the count are named, and the output is meaningless).
void pu21_encode(std::span<const float> luminance_cd_m2, std::span<float> pu21,
                 Pu21Variant = Pu21Variant::kBandingGlare);

/// GLSL functions pu21_encode(float or vec3, int variant) and pu21_decode, to paste after the
/// #version line of a shader; see pu21.glsl.
const char* pu21_glsl();

/// 10 log10(256^2 / MSE) in dB over R, G, B encoded separately (banding_glare); +infinity for
/// equal images. Only pixels with mask != 0 count. The same for any number of threads; within
/// 1e-4 dB of the score in double precision. All scores below share the errors:
/// ArgumentError for empty images, sizes that differ, an empty mask, a picture that is all black,
/// NaN/infinite/negative light.
double pu21_psnr_rgb(const RgbImage& test, const RgbImage& reference,
                     const cv::Mat1b* mask = nullptr);
/// The same on luminance (kLuminanceWeights before encoding).
double pu21_psnr_luminance(const RgbImage& test, const RgbImage& reference,
                           const cv::Mat1b* mask = nullptr);
/// Per pixel: root mean square over R, G, B of the difference in PU21 units, >= 0.
ScalarImage pu21_difference(const RgbImage& test, const RgbImage& reference);

/// PSNR in dB, peak 255, of the 8-bit sRGB pictures in which `white_cd_m2` is code 255.
/// Errors: as above, but black is allowed; ArgumentError unless white_cd_m2 > 0.
double srgb_psnr(const RgbImage& test, const RgbImage& reference, double white_cd_m2,
                 const cv::Mat1b* mask = nullptr);

}  // namespace wheatstone
