#pragma once
// How visible the difference of two band pyramids is, after masking, and what an observer makes of
// it in all. Source: HDR-VDP-3 (reference metrics.md, section 4, steps 7 to 9), and for the map of
// detection the psychometric function and the pooling of Mantiuk et al., SIGGRAPH 2011, section 5.

#include <opencv2/core.hpp>
#include <vector>

namespace wheatstone {

struct BandDifferences {
  double q_err = 0;                 // pooled over pixels and bands
  std::vector<cv::Mat1d> contrast;  // per band: threshold units after the psychometric exponent,
                                    // signed; 1 = seen half the time
};

/// test, reference  bands as steerable_bands() gives them, mean of the last one removed. Those of
///                  the test are consumed: their memory becomes the result.
/// log10_adaptation log10 of cd/m^2, in the images' size.
/// differs          1 where the images differ by more than 0.1 %, 0 elsewhere, images' size.
/// Same bytes for every number of threads.
BandDifferences visible_difference(std::vector<cv::Mat1d>&& test,
                                   const std::vector<cv::Mat1d>& reference,
                                   const cv::Mat1d& log10_adaptation, const cv::Mat1d& differs,
                                   double pixels_per_degree);

struct Detection {
  cv::Mat1d probability;        // per pixel, of a difference within about 0.3 deg; may be -1e-4
  double p_det = 0, c_max = 0;  // largest local means (0.25 deg) of probability and of contrast
};

/// From the differences of all bands back to one image of probability.
Detection detect(const BandDifferences&, double pixels_per_degree);

}  // namespace wheatstone
