#pragma once
// Views without lens distortion, cropped to the same rectangle of the box.

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "core/geometry.h"
#include "core/image.h"
#include "core/rig_types.h"

namespace wheatstone {

/// The rectangle every view has to show, in rsb, and how much more around it.
struct CommonBox {
  Eigen::Vector2d min_mm{75, 25}, max_mm{295, 235};  // x, y
  double z_mm = 0;
  int margin_px = 8;
};

/// Smallest size that holds the rectangle's projection and the margin in every view. Throws
/// ArgumentError for no poses or a rectangle that is empty or behind a camera.
cv::Size common_size(const Intrinsics&, std::span<const RigidTransform> T_camera_rsb,
                     const CommonBox&);

/// Removes the distortion and crops to `size` (from common_size over all views) around the
/// rectangle. The crop moves by whole pixels, so a view without distortion is copied exactly;
/// focal length and skew stay, the principal point moves. Where the rectangle reaches out of the
/// photo, as from the ends of the rail, the crop stops at the photo's edge, so every pixel of it
/// was photographed. Sampling is Catmull-Rom, limited to the range of the four nearest pixels: no
/// overshoot and no negative light. Throws ArgumentError, naming the view, when the photo is not of
/// the intrinsics' size, when `size` is too small, or when the photo is smaller than `size` or does
/// not show the rectangle's middle.
LightFieldView rectify_to_common_box(const std::string& name, const RgbImage& distorted,
                                     const Intrinsics&, const Distortion&,
                                     const RigidTransform& T_camera_rsb, const CommonBox&,
                                     cv::Size size);

/// The same, but the crop is as small as this one view allows: the rectangle's projection and the
/// margin, as far as they were photographed. Errors: ArgumentError, naming the view, when the photo
/// is not of the intrinsics' size or does not show the rectangle.
LightFieldView rectify_to_own_box(const std::string& name, const RgbImage& distorted,
                                  const Intrinsics&, const Distortion&,
                                  const RigidTransform& T_camera_rsb, const CommonBox&);

}  // namespace wheatstone
