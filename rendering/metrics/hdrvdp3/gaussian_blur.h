#pragma once
// The Gaussian low-pass of HDR-VDP-3, with its way of continuing an image beyond the borders.

#include <opencv2/core.hpp>

namespace wheatstone {

enum class BlurBorder {
  kReplicate,  // the image goes on as its edge
  kZero        // the image goes on as 0
};

/// Replaces the image by its mean under a Gaussian of sigma_px > 0.
///
/// The original filters wide Gaussians (sigma >= 4.3 px) in the Fourier domain, on the image
/// continued to twice its size to the right and down, so that on the left and at the top the
/// continuation comes around: with kReplicate a left neighbour is the row's *last* sample. Here the
/// same numbers come from the sampled Gaussian, cut at 6 sigma (2e-9 of it are lost). Narrow
/// Gaussians are cut near 3 sigma and continue each edge on its own side.
/// Same bytes for every number of threads. Source: reference metrics.md, section 4, step 3.
void gaussian_blur(cv::Mat1d&, double sigma_px, BlurBorder);

}  // namespace wheatstone
