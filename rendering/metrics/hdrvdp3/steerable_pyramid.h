#pragma once
// Steerable pyramid with one orientation: an image as bands of one octave each.
// Source: Simoncelli and Freeman, "The steerable pyramid", ICIP 1995; filters "sp0" of
// matlabPyrTools; levels and scaling as in HDR-VDP-3 (reference metrics.md, section 4, step 6).

#include <opencv2/core.hpp>
#include <vector>

namespace wheatstone {

/// Number h of halvings: the coarsest band is 1 cpd or the smallest on which the filters fit.
/// Pre: both sides >= 13, pixels_per_degree >= 4.
int steerable_levels(cv::Size, double pixels_per_degree);

/// Centre of band b (0 = finest).
double band_frequency_cpd(int band, double pixels_per_degree);

/// h + 2 bands: the high-pass residual and the first level in the image's size, every further
/// level half as large (rounded up), the low-pass residual. Band b is divided by 2^b, which keeps
/// the amplitude of a pattern whatever band it falls in. Beyond its borders the image goes on as
/// its mirror image about the edge sample. Pre: both sides >= 13 at every level.
std::vector<cv::Mat1d> steerable_bands(const cv::Mat1d& image, int levels);

/// The image whose bands these are, within 5 %: the filters are not perfect.
cv::Mat1d reconstruct_from_bands(const std::vector<cv::Mat1d>& bands);

}  // namespace wheatstone
