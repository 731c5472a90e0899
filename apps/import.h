#pragma once
// Real input into dataset folders.

#include <filesystem>
#include <string>

#include "core/dataset.h"

namespace wheatstone::apps {

struct ImportOptions {
  std::string format = "auto";  // auto, exr-stereo, light-field-renderer, colmap, nerf, llff, poses
  double white_cd_m2 = 100;     // luminance of full white; for stereo EXR of the value 1
  double mm_per_unit = 0;       // 0: 1 for light fields; for stereo depth, so that the median
                                // depth lies midway between the display planes in dioptres
  double hfov_deg = 13.2;       // stereo EXR only: field of view of the picture's width
  std::string convention = {};  // of nerf and llff poses; empty: the file's own, or the format's
};

/// Writes dataset.json, views/, views.json (and depth/ for stereo). Returns a line for people.
/// Errors: FileError, ArgumentError; dataset.json is written last, so a folder without it is
/// no dataset.
std::string import_input(const std::filesystem::path& input, const Dataset&, const ImportOptions&);

}  // namespace wheatstone::apps
