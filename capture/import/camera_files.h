#pragma once
// One camera's intrinsics and distortion in the files of other programs: OpenCV's YAML, COLMAP's
// cameras.txt, Kalibr's camchain. Pixels inside are converted to and from each program's own.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry.h"

namespace wheatstone {

struct CameraFile {
  Intrinsics intrinsics;
  Distortion distortion;
};

enum class CameraFormat { kOpenCv, kColmap, kKalibr };
std::string to_string(CameraFormat);                         // "opencv", "colmap", "kalibr"
CameraFormat camera_format_from_string(const std::string&);  // throws ArgumentError

/// The cameras of a file, in its order; the kind is told from the contents.
///   OpenCV: camera_matrix, distortion_coefficients (4, 5 or 8; fisheye if fisheye_model is true),
///           image_width, image_height. One camera.
///   COLMAP: cameras.txt, models as in read_colmap().
///   Kalibr: cam0, cam1, ...: pinhole with radtan, equidistant or none.
/// Errors: FileError: missing, damaged, another kind, a model or coefficients that cannot be held.
std::vector<CameraFile> read_camera_file(const std::filesystem::path&);

/// Empty if the format can hold this lens exactly; else why not and what to do.
/// Kalibr has no k3 to k6, COLMAP no skew.
std::string why_not_exact(CameraFormat, const CameraFile&);

/// Writes the file atomically; numbers read back exactly. For Kalibr cam0, cam1, ... in this
/// order, with T_cn_cnm1 (translation in m, as there) if `T_second_first` is given.
/// Errors: ArgumentError: why_not_exact(); FileError.
void write_camera_file(const std::filesystem::path&, CameraFormat, const std::vector<CameraFile>&,
                       const std::optional<RigidTransform>& T_second_first = std::nullopt);

}  // namespace wheatstone
