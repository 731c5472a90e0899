#pragma once
// frames.json: an exposure stack described by hand or by a script (docs/hdr_merge.md).

#include <filesystem>
#include <vector>

#include "capture/merge.h"
#include "capture/strict_object.h"

namespace wheatstone {

struct ExposureStack {
  std::vector<std::filesystem::path> files;  // as found, in the order of frames.json
  std::vector<RawExposure> exposures;        // of the same order
  MergeOptions merging;
};

/// The stack with its frames loaded. Ready-made frames (16-bit PNG, TIFF, PGM) take pattern, bits,
/// black level and times from frames.json; camera raw files say these themselves, and then
/// frames.json must not (but may give times that the files lack). Camera raw codes count as
/// saturated from 0.98 of the white level on. Paths are relative to the folder of frames.json.
/// Errors: FileError naming frames.json and the key: missing, unknown, of the wrong type or out of
/// range, a file listed twice, noise parameters missing for the estimator "full"; or naming the
/// frame's file: missing, damaged, not 16-bit with one channel, codes beyond `bits`, without a
/// time, unlike the first one.
ExposureStack read_exposure_stack(const std::filesystem::path& frames_json);

/// Key "noise": an object with noise_k_rgb, std_read, std_adc, or the path of a noise profile.
SensorNoise noise_from(const StrictObject&, const std::filesystem::path& file);

/// Keys "pattern", "bits", "black" and "saturation" of ready-made frames.
struct CodeRange {
  BayerPattern pattern = BayerPattern::kRggb;
  int bits = 16, saturation_dn = 65535;
  std::array<double, 4> black_dn = {0, 0, 0, 0};
};
CodeRange code_range_from(const StrictObject&);
/// FileError unless the file is a frame of that pattern and of codes within the bits.
MosaicImage read_frame(const std::filesystem::path&, const CodeRange&);

/// A mosaic as the program's commands take it: an OpenEXR file with one float or half channel
/// outside of any layer, or a 16-bit one-channel PNG, TIFF or PGM (codes as values).
/// Errors: FileError: the file, and for a value that is NaN or infinite, its place.
LinearMosaic read_linear_mosaic(const std::filesystem::path&, BayerPattern);

}  // namespace wheatstone
