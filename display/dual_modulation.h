#pragma once
// Dual modulation: an LCD lit by a projector image. Forward model of core's PanelModel and the
// square-root split (Seetzen et al. 2004; reference dual_modulation.md).

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "core/image.h"
#include "core/rig_types.h"

namespace wheatstone {

/// Projector factor p (projector size, 0..1) to the backlight B = PSF * p_warped (LCD size).
/// p is sampled bilinearly through H_lcd_projector, neighbours outside the projector's image
/// count as 0; light that falls beside the LCD still reaches it through the PSF. Each lobe is a
/// separable Gaussian cut at 4 sigma with sum 1.
/// Errors: ArgumentError: impossible panel model, wrong size, factor outside 0..1 or NaN.
ScalarImage simulate_backlight(const PanelModel&, const ScalarImage& projector_factor);

/// Light of both drives, LCD size, cd/m^2. Errors: ArgumentError as above, or drives that have
/// not the panel's sizes and types.
RgbImage simulate_light(const PanelModel&, const DriveImage& projector, const DriveImage& lcd);

/// kNearest has the smallest error per pixel; kOrderedDither (4x4 Bayer, thresholds in linear
/// light) has the smallest error in the mean over 4x4 pixels.
enum class LcdRounding { kNearest, kOrderedDither };

struct DualDrive {
  DriveImage projector, lcd;  // CV_8UC1 in projector size, CV_8UC3 (R, G, B) in LCD size
  RgbImage light_cd_m2;       // what the model says these drives show
  int above_peak_px = 0;      // pixels with a channel brighter than the display can show there
  int below_black_px = 0;     // pixels with a channel darker than the display can show there
};

/// Drives that show `target_cd_m2` (LCD size). The projector carries sqrt(max(R, G, B)), dilated
/// so that its blurred light suffices wherever the projector can reach; the LCD divides the rest
/// by the backlight of the quantised projector drive.
/// Errors: ArgumentError: impossible panel model, wrong size, NaN, infinite or negative light.
DualDrive split_dual_modulation(const PanelModel&, const RgbImage& target_cd_m2,
                                LcdRounding = LcdRounding::kNearest);

/// Gaussian of `sigma_px` sampled at -radius..radius, sum 1. Pre: sigma_px >= 0 (0: a delta).
std::vector<double> gaussian_kernel(double sigma_px, int radius_px);

/// Convolution with the outer product of a symmetric odd kernel; 0 outside the image.
cv::Mat1d convolve_separable(const cv::Mat1d& image, std::span<const double> kernel);

/// The split alone, one channel, registered and unquantised: projector = sqrt(target),
/// backlight = kernel * projector, lcd = clip(target/backlight, lcd_black, 1); 1 = peak.
struct SqrtSplit {
  cv::Mat1d projector, backlight, lcd;
};
SqrtSplit split_sqrt(const cv::Mat1d& target, std::span<const double> kernel, double lcd_black);

}  // namespace wheatstone
