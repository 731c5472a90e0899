#pragma once
// Camera raw files (DNG, ARW, CR2, ...) through LibRaw: what the file says, nothing assumed.

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "core/image.h"

namespace wheatstone {

/// One photograph as the sensor read it: the visible area, not rotated.
struct CameraRaw {
  MosaicImage mosaic;
  std::array<double, 4> black_dn;  // at (0,0), (0,1), (1,0), (1,1) of each cell
  int white_dn = 0;                // the file's white level
  // 0 or empty where the file does not say.
  double exposure_s = 0, iso = 0, f_number = 0;
  std::string camera, serial;
};

/// Errors: FileError: missing, damaged, no camera raw file, a sensor without a 2x2 Bayer pattern of
/// red, green and blue, no white level above black, larger than 200 Mpixel or than the file's own
/// length makes plausible.
CameraRaw read_camera_raw(const std::filesystem::path&);

/// The same of a file in memory; `name` stands for it in errors.
CameraRaw decode_camera_raw(std::span<const std::byte>, const std::filesystem::path& name);

}  // namespace wheatstone
