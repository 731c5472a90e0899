#pragma once
// OpenEXR in and out. Reading is made for hostile files: sizes are checked against the file's own
// length before memory is taken, and every library failure comes back as FileError.

#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/image.h"

namespace wheatstone {

/// What an RGB file holds beside its pixels.
struct ExrMetadata {
  /// Luminance of R = G = B = 1 as stored; 0 when the file does not say (attribute
  /// whiteLuminance). Files that Wheatstone writes always say 1 and hold cd/m^2.
  double white_luminance_cd_m2 = 0;
  bool has_bt709_chromaticities = true;  // false: the file names other primaries
};

/// Linear RGB in the display window, channels R, G, B, as stored (no scaling).
/// Errors: FileError: missing, damaged, deep, no R/G/B, larger than 16384 x 16384 or 200 Mpixel,
/// shorter than its header promises; NaN, infinite or negative samples (counted, first place
/// named). Samples outside the data window are 0. Subsampled channels are refused.
RgbImage read_exr(const std::filesystem::path&, ExrMetadata* = nullptr);

/// How the samples of a channel are stored.
enum class ExrPrecision { kHalf, kFloat };

/// Writes R, G, B as half (default) or float, ZIP compressed, with BT.709 chromaticities and
/// whiteLuminance 1. Half loses at most 0.05 % and saturates at 65504: larger values are refused.
/// Errors: FileError (path, permission, space); ArgumentError for invalid radiance.
void write_exr(const std::filesystem::path&, const RgbImage& light_cd_m2,
               ExrPrecision = ExrPrecision::kFloat);

/// One scalar channel named `channel` ("Y", "Z", ...), float.
void write_exr(const std::filesystem::path&, const ScalarImage&, const std::string& channel);

/// A flat picture of named channels, for write_exr_rows.
struct ExrChannel {
  std::string name;  // "R", "Y", "sigma.Y", ... a name before the dot is a layer
  ExrPrecision precision = ExrPrecision::kFloat;
};
enum class ExrCompression { kZip, kPiz };
struct ExrPicture {
  cv::Size size;
  std::vector<ExrChannel> channels;
  bool is_light =
      false;  // R, G, B (or Y) are cd/m^2: the file then says BT.709 and whiteLuminance 1
  ExrCompression compression = ExrCompression::kZip;
};

/// Writes the picture band by band, so that it never stands in memory as a whole: fill(rows, bands)
/// is called in order of the rows and fills bands[i](r - rows.start, c) of every channel. Bands are
/// compressed on all cores; the bytes do not depend on their number. The values are not judged:
/// camera colours and their deviations may be negative, which light must not be.
/// Errors: FileError (path, permission, space); ArgumentError for an empty picture, a channel
/// without a name or named twice, and samples that do not fit half precision (65504).
using FillExrRows = std::function<void(cv::Range rows, std::span<cv::Mat1f> bands)>;
void write_exr_rows(const std::filesystem::path&, const ExrPicture&, const FillExrRows& fill);

/// The channels of one view of a flat (not deep) file, single or multi part, single or multi view.
struct ExrView {
  std::string name;                             // "left", "right", or "" in a single-view file
  std::map<std::string, ScalarImage> channels;  // by base name: R, G, B, A, Z, disparityL.x, ...
  int width_px = 0, height_px = 0;              // the display window
};

/// Every view of the file, every float/half channel placed in the display window (0 outside the
/// data window; parts may have different data windows). View names come from the `multiView`
/// attribute or the parts' `view` attributes; in a `multiView` file, channels without a prefix
/// belong to the first view. Same errors as read_exr, except that sample values are not judged.
std::vector<ExrView> read_exr_views(const std::filesystem::path&);

}  // namespace wheatstone
