#pragma once
// From camera colours in DN/s to light.

#include <opencv2/core.hpp>

#include "capture/merge.h"
#include "core/image.h"
#include "core/rig_types.h"

namespace wheatstone {

/// Linear BT.709 light in cd/m^2 from camera RGB in DN/s at ISO 100 (shape [h][w][R, G, B]):
/// inverse of the profile's response, negatives clipped to 0 at the very end. Throws ArgumentError
/// when the profile's sensitivity is not positive or its colour matrix has no inverse.
RgbImage to_radiance(const cv::Mat3f& camera_rgb_dn_s, const CameraProfile&);

/// Standard deviation, cd/m^2, of the luminance of each 2x2 cell as its red, green and blue
/// photosites tell it; all four pixels of a cell have the cell's. Their errors are independent and
/// luminance is linear in them, so nothing is approximated but that negatives are not clipped and
/// that the saturated are taken as measured. Half cells at the edge of odd sizes have their whole
/// neighbour's. Same size as the mosaic; empty without deviations. Errors: as to_radiance(), and
/// ArgumentError for less than one cell.
cv::Mat1f luminance_deviation(const MergedMosaic&, const CameraProfile&);

}  // namespace wheatstone
