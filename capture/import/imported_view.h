#pragma once
// What every importer returns: a posed camera and where its picture lies.

#include <filesystem>
#include <string>

#include "core/geometry.h"
#include "core/image.h"
#include "core/rig_types.h"

namespace wheatstone {

/// A posed picture that is not loaded yet. `path` is empty when the file is not there.
struct ImportedView {
  std::string name;
  std::filesystem::path path;
  Intrinsics intrinsics;  // first pixel's centre is (0, 0)
  Distortion distortion;
  RigidTransform T_camera_world;
};

/// Reads the picture (sRGB, `white_cd_m2` at full code; or linear EXR, `white_cd_m2` at 1 where the
/// file has no whiteLuminance) and removes its distortion, so that the view is a pinhole with the
/// same K; pixels without a source are 0.
/// Errors: FileError: no file, unreadable, its size is not that of the intrinsics, or an EXR has
/// primaries other than BT.709.
LightFieldView load_view(const ImportedView&, double white_cd_m2);

/// Width and height from a JPEG's or PNG's header, without decoding. FileError.
cv::Size picture_size(const std::filesystem::path&);

}  // namespace wheatstone
