#pragma once
// Pictures shaded at the rates of a map: shaded once per block and surface, at the block's centre,
// while every pixel keeps the surface that it sees. This is what graphics hardware does with a
// shading-rate image, and what shading_point.frag does without one.
// Source: thesis (UCAM-CL-TR-977), chapter 6; OpenGL extension NV_shading_rate_image.

#include <functional>

#include "core/image.h"
#include "rendering/motion_quality/alsarr/shading_rate.h"

namespace wheatstone {

/// The centre of the block that holds a pixel, OpenCV convention: (1.5, 1.5) for the first 4x4.
/// Pre: x_px, y_px >= 0.
cv::Point2d shading_point(const ShadingRate&, int x_px, int y_px);

struct CoarseShading {
  RgbImage light_cd_m2;
  std::int64_t shades = 0;  // calls of the shading function
};
/// surface: which one each pixel sees, any index; shade(surface, point): its light there, cd/m^2.
/// Errors: ArgumentError for no pixels or an invalid map.
CoarseShading shade_coarsely(
    const cv::Mat1i& surface, const ShadingRateMap&,
    const std::function<cv::Vec3f(int surface, const cv::Point2d& point)>& shade);

/// A finished picture as the shading function: bilinear, one surface everywhere, so that edges of
/// objects turn coarse as well. Errors: as above.
RgbImage shade_picture_coarsely(const RgbImage&, const ShadingRateMap&);

}  // namespace wheatstone
