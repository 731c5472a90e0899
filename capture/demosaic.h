#pragma once
// All three colours at every photosite of a linear mosaic.

#include <opencv2/core.hpp>

#include "core/image.h"

namespace wheatstone {

/// Bilinear interpolation: [height][width][R, G, B] in the mosaic's unit, measured samples kept.
/// At the border only samples that exist count (normalised convolution), so a constant stays
/// constant up to the edge. Odd sizes are allowed. Throws ArgumentError below 2 x 2 pixels.
cv::Mat3f demosaic_bilinear(const LinearMosaic&);

}  // namespace wheatstone
