#pragma once
// Structural similarity of PU21 values, at one scale and at five.
// Sources: Wang et al., "Image quality assessment: from error visibility to structural similarity",
// IEEE TIP 2004; Wang, Simoncelli and Bovik, "Multi-scale structural similarity", Asilomar 2003;
// conventions of reference metrics.md, section 1.

#include "core/image.h"

namespace wheatstone {

/// Mean SSIM of the luminance (kLuminanceWeights) encoded with PU21 (banding_glare): 11x11 Gaussian
/// window of sigma 1.5 px, replicated borders, dynamic range 256, K1 = 0.01, K2 = 0.03, variances
/// without Bessel correction, mean over the whole map, borders included. 1 for equal images.
/// mask  only map pixels with mask != 0 count; the windows still see the whole picture.
/// map   if given, receives the SSIM of each pixel, -1..1.
/// Within 1e-6 of double precision; the same for any number of threads and on every processor.
/// Errors: ArgumentError for empty images, sizes that differ, an empty mask, a picture that is all
/// black, NaN/infinite/negative light.
double pu21_ssim_luminance(const RgbImage& test, const RgbImage& reference,
                           const cv::Mat1b* mask = nullptr, ScalarImage* map = nullptr);
/// The same, mean of R, G and B encoded separately.
double pu21_ssim_rgb(const RgbImage& test, const RgbImage& reference,
                     const cv::Mat1b* mask = nullptr, ScalarImage* map = nullptr);

/// The smallest side that five scales leave an 11 px window: 11 * 2^4.
inline constexpr int kMsSsimMinSide_px = 176;

/// Multi-scale SSIM: the mean contrast-structure factors of scales 1 to 4 and the mean SSIM of
/// scale 5, to the powers 0.0448, 0.2856, 0.3001, 0.2363, 0.1333, multiplied. Each scale averages
/// 2x2 px of PU21 values of the one before (an odd last row or column is repeated). A mean below 0
/// counts as 0. A mask is averaged alike and weighs the means.
/// Errors: as above, and ArgumentError for a side below kMsSsimMinSide_px.
double pu21_ms_ssim_luminance(const RgbImage& test, const RgbImage& reference,
                              const cv::Mat1b* mask = nullptr);
double pu21_ms_ssim_rgb(const RgbImage& test, const RgbImage& reference,
                        const cv::Mat1b* mask = nullptr);

}  // namespace wheatstone
