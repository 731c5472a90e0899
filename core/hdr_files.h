#pragma once
// Linear pictures in two older formats: Portable Float Map and Radiance RGBE. Reading is made for
// hostile files: sizes are checked against the file's own length before memory is taken.

#include <filesystem>

#include "core/image.h"

namespace wheatstone {

/// Portable Float Map: "PF" (R, G, B) or "Pf" (grey, becomes R = G = B), either byte order; the
/// bottom row comes first in the file. Values as stored: the file does not say what 1 means.
/// Errors: FileError: missing, damaged, larger than 16384 x 16384 or 200 Mpixel, shorter or longer
/// than its header promises; a scale factor other than 1 and -1 (programs disagree on its meaning);
/// NaN, infinite or negative samples (counted, first place named).
RgbImage read_pfm(const std::filesystem::path&);

/// Radiance picture (.hdr, .pic): rows stored flat or run-length coded by component, in the usual
/// order "-Y height +X width". Values as stored, divided by the header's EXPOSURE if it has any
/// (they multiply, as Radiance defines). Written anew rather than taken from OpenCV, whose reader
/// ignores EXPOSURE, COLORCORR and PRIMARIES and so returns other light than the file's.
/// Errors: FileError: missing, damaged, too large or too short as above; XYZ pixels, COLORCORR,
/// other primaries than BT.709, other orientations, the run lengths of before 1991.
RgbImage read_radiance_hdr(const std::filesystem::path&);

}  // namespace wheatstone
