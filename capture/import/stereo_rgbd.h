#pragma once
// Stereo colour and depth from multi-view OpenEXR files.

#include <filesystem>
#include <span>

#include "core/exr.h"
#include "core/image.h"

namespace wheatstone {

/// One eye's picture. Colour as stored: premultiplied by A, that is, over black. Depth in the
/// file's own unit. `mask` is 255 where something was rendered: depth finite and above 0 and,
/// if the view has A, A above 0; 0 elsewhere.
struct EyeRgbd {
  RgbImage light;
  ScalarImage z_units;
  cv::Mat1b mask;
};

struct StereoRgbd {
  EyeRgbd left, right;
};

/// From read_exr_views(); `file` is named in errors. Errors: FileError naming the missing view
/// ("left", "right") or channel (R, G, B, Z), views of different sizes, colour that is NaN,
/// infinite or negative.
StereoRgbd stereo_rgbd(std::span<const ExrView>, const std::filesystem::path& file);

}  // namespace wheatstone
