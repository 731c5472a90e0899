#pragma once
// Picture folders of L. Mossberg's light-field-renderer: camera positions in the file names.

#include <filesystem>
#include <vector>

#include "capture/import/imported_view.h"

namespace wheatstone {

/// One view per file <scene>_<row>_<col>_<-y mm>_<x mm>_<focal mm>_<sensor width mm>.jpg or .png,
/// sorted by name; other files are left alone. World: x right, y up, all cameras in z = 0 looking
/// along -z, so T_camera_world.R = diag(1, -1, -1). The principal point is the picture's middle.
/// Errors: FileError: no such folder, no picture of that kind, impossible numbers in a name,
/// a picture without a readable header.
std::vector<ImportedView> read_light_field_folder(const std::filesystem::path& folder);

}  // namespace wheatstone
