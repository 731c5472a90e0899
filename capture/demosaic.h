#pragma once
// All three colours at every photosite of a linear mosaic.

#include <opencv2/core.hpp>

#include "core/image.h"

namespace wheatstone {

/// Directional filtering with an a posteriori decision (DDFAPD): shape [height][width][R, G, B], in
/// the mosaic's unit. Measured samples are kept, nothing is clipped: beside sharp edges values may
/// overshoot and become negative. Borders are mirrored without repeating the edge; any size of at
/// least 2 x 2, odd ones too. Where both directions fit exactly equally well, rounding chooses.
///
/// refine  the paper's refining step (section IV), on by default.
/// Errors  ArgumentError for less than 2 x 2 pixels.
/// Source  D. Menon, S. Andriani, G. Calvagno, "Demosaicing With Directional Filtering and a
///         posteriori Decision", IEEE Trans. Image Processing 16(1), 2007.
cv::Mat3f demosaic(const LinearMosaic&, bool refine = true);

/// The same for the given rows of the mosaic only, so that a picture can be made band by band: bit
/// for bit the rows that demosaic() of the whole gives. `rows` must lie in the mosaic. `out` is
/// used again if it has the right size.
void demosaic_rows(const LinearMosaic&, cv::Range rows, cv::Mat3f& out, bool refine = true);

}  // namespace wheatstone
