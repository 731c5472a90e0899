#pragma once
// A plain list of posed pictures, for captures from programs without an importer of their own.

#include <filesystem>
#include <span>
#include <vector>

#include "capture/import/imported_view.h"

namespace wheatstone {

inline constexpr const char* kPosesSchema = "wheatstone-poses/1";

/// Poses mean nothing without their convention, so the file must state this one, word for word.
inline constexpr const char* kPoseConvention =
    "T_camera_world: x_camera = R x_world + t_mm; camera axes x right, y down, z forward (OpenCV); "
    "pixel centre of the first pixel is (0,0)";

/// {"schema", "convention", "views": [{"name", "file" (relative to the JSON file or absolute),
/// "K": {"fx_px", "fy_px", "cx_px", "cy_px", optional "skew_px"}, optional "distortion":
/// {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "fisheye": true or false}, "size": [width,
/// height], "R": three rows, "t_mm"}]}. A view whose file is not there gets an empty path. Errors:
/// FileError: as read_json; no or another convention (says the sentence to add); a missing key; R
/// not a rotation to 1e-6; f <= 0; a size outside 1..65536.
std::vector<ImportedView> read_poses_json(const std::filesystem::path&);

/// Files inside the JSON file's folder are written relative to it.
void write_poses_json(const std::filesystem::path&, std::span<const ImportedView>);

}  // namespace wheatstone
