#pragma once
// transforms.json of NeRF (Mildenhall et al. 2020), instant-ngp and Nerfstudio.

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "capture/import/pose_convention.h"

namespace wheatstone {

struct NerfModel {
  std::vector<ImportedView> views;       // in the file's order
  std::vector<KnownPoint> known_points;  // what "check_points" holds
  PoseConvention convention;             // the one the poses were read with
};

/// Reads transforms.json. Camera: fl_x, fl_y (or camera_angle_x), cx, cy, w, h, k1, k2, p1, p2, k3,
/// k4 and camera_model (OPENCV, PINHOLE, OPENCV_FISHEYE), in the file or in each frame; a missing
/// size is read from the picture. Pixels there have the first centre at (0.5, 0.5). Poses:
/// frames[i] .transform_matrix, in `convention` if given, else in the file's "convention", else in
/// kNerfConvention. Lengths are multiplied by mm_per_unit. Pictures are looked for beside the file,
/// with .png, .jpg or .jpeg added if need be.
/// Errors: FileError: missing, damaged, impossible values; a `convention` that contradicts the
/// file's. ArgumentError unless mm_per_unit > 0.
NerfModel read_nerf(const std::filesystem::path&, double mm_per_unit = 1,
                    std::optional<PoseConvention> convention = std::nullopt);

/// Writes transforms.json with the key "convention" and "check_points" (points of the world, their
/// pixels in each frame), atomically. Lengths in mm. Errors: ArgumentError for a skewed camera
/// matrix or a lens with k3 or more beside p1, p2 (the format has none), FileError.
void write_nerf(const std::filesystem::path&, std::span<const ImportedView>,
                std::span<const KnownPoint>);

}  // namespace wheatstone
