#pragma once
// Which blobs of a frame are the marker LEDs, by where the LEDs stand on the wall.

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>

#include "calib/markers.h"
#include "core/geometry.h"

namespace wheatstone {

/// The four blobs that a camera can see where `markers_rsb` says (mm, in the order bottom-left,
/// bottom-right, top-left, top-right), in that order. Of several such sets among the eight
/// strongest blobs the strongest counts, so that reflections and lamps do no harm.
///
/// Throws ArgumentError, beginning with `what`, as order_markers(), and when the geometry
/// contradicts: it says which two LEDs are swapped, or which one is missing or hidden (something
/// else was taken for it), if that explains the rest.
std::array<MarkerBlob, 4> match_markers(std::span<const MarkerBlob> blobs,
                                        std::span<const Eigen::Vector3d> markers_rsb,
                                        const Intrinsics&, const Distortion&,
                                        const std::string& what);

}  // namespace wheatstone
