#pragma once
// COLMAP's camera models and ours. Internal to the COLMAP reader and writers.

#include <string>
#include <vector>

#include "capture/import/colmap_records.h"
#include "core/geometry.h"

namespace wheatstone::colmap_detail {

inline constexpr double kPixelCentre = 0.5;  // COLMAP's coordinate of the first pixel's centre

struct Lens {
  Intrinsics intrinsics;
  Distortion distortion;
};

/// Errors: FileError at the record's place: impossible sizes or numbers.
Lens lens_of(const Camera&);

/// The record of the simplest of PINHOLE, OPENCV, FULL_OPENCV and OPENCV_FISHEYE that holds the
/// lens exactly. ArgumentError for a skewed camera matrix.
Camera camera_of(std::uint64_t id, const Intrinsics&, const Distortion&);

/// The record as a line of cameras.txt, without its end; numbers read back exactly.
std::string camera_line(const Camera&);

}  // namespace wheatstone::colmap_detail
