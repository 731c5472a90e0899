#pragma once
// COLMAP models out, text and binary (colmap.github.io/format.html); the reader is colmap.h.

#include <filesystem>
#include <span>

#include "capture/import/pose_convention.h"

namespace wheatstone {

/// Writes cameras, images and points3D (.txt or .bin) into the folder, which is made if need be,
/// each atomically. One camera per different lens; pixel centres and poses are converted; lengths
/// in mm. The known points become points3D with their tracks; equal neighbouring positions are one
/// point. A picture is named by its file's name. Numbers read back exactly.
/// Errors: ArgumentError for a skewed camera matrix or no view; FileError.
void write_colmap(const std::filesystem::path& folder, bool binary, std::span<const ImportedView>,
                  std::span<const KnownPoint>);

}  // namespace wheatstone
