#pragma once
// From camera colours in DN/s to light.

#include <opencv2/core.hpp>

#include "core/image.h"
#include "core/rig_types.h"

namespace wheatstone {

/// Linear BT.709 light in cd/m^2 from camera RGB in DN/s at ISO 100 (shape [h][w][R, G, B]):
/// inverse of the profile's response, negatives clipped to 0 at the very end. Throws ArgumentError
/// when the profile's sensitivity is not positive or its colour matrix has no inverse.
RgbImage to_radiance(const cv::Mat3f& camera_rgb_dn_s, const CameraProfile&);

}  // namespace wheatstone
