#pragma once
// Pictures of every format the program reads, as absolute light.

#include <filesystem>
#include <optional>
#include <vector>

#include "core/image.h"
#include "rendering/metrics/viewing.h"

namespace wheatstone::apps {

/// How files that do not say it themselves become cd/m^2.
struct LightOptions {
  /// Light of value 1 (linear files) or of full code (integer pictures), from `display`'s peak.
  std::optional<double> peak_cd_m2;
  bool absolute = false;  // linear files hold cd/m^2
  GogDisplay display;     // of integer pictures; its peak is peak_cd_m2
};

/// OpenEXR, PFM and Radiance pictures are linear: an EXR with whiteLuminance keeps that scale;
/// otherwise `absolute`, then `peak_cd_m2` decides. 8- and 16-bit PNG, TIFF and JPEG go through the
/// display model with `peak_cd_m2`. An EXR must have BT.709 primaries.
/// Errors: FileError: those of the readers, an unknown extension, other primaries, and no scale
/// stated by the file or the options.
RgbImage read_light(const std::filesystem::path&, const LightOptions&);

/// Whether read_light knows the extension.
bool is_picture(const std::filesystem::path&);

/// A picture whose pixels above 0 in any channel are selected. Errors: FileError.
cv::Mat1b read_mask(const std::filesystem::path&);

}  // namespace wheatstone::apps
