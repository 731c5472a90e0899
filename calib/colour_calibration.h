#pragma once
// Camera colours to light, from chart patches measured with a spectroradiometer.

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/rig_types.h"

namespace wheatstone {

/// What the camera and the instrument say of one patch.
struct ChartPatch {
  Eigen::Vector3d camera_rgb;  // merged camera colours, DN/s at ISO 100
  Eigen::Vector3d reference;   // linear RGB or XYZ in absolute units
};

/// kRelative divides each patch by the mean of its reference, so that dark patches count as much
/// as bright ones: preferable for HDR.
enum class ChartWeighting { kNone, kRelative };

/// The 3x3 M of least squares, reference = M camera_rgb, without offset.
/// Errors: ArgumentError for fewer than three patches, colours that do not span the space, numbers
/// that are not finite, and with kRelative a patch whose reference has no positive mean.
Eigen::Matrix3d fit_colour_matrix(const std::vector<ChartPatch>&, ChartWeighting);

/// The two patches whose references, exchanged, make the chart fit at least three times better; the
/// pair that does so best. Relative weighting. Errors: as fit_colour_matrix().
std::optional<std::pair<std::size_t, std::size_t>> swapped_patches(std::vector<ChartPatch>);

/// Scales M so that the camera gives `patch` exactly the luminance of its reference: the absolute
/// scale of the reference patch, the colours of the whole chart. References are BT.709 in cd/m^2.
/// Errors: ArgumentError for a patch without positive luminance.
Eigen::Matrix3d scaled_to_patch(const Eigen::Matrix3d& M, const ChartPatch& patch);

/// Puts M (camera RGB in DN/s at ISO 100 to BT.709 in cd/m^2) into the profile: its inverse, split
/// into the sensitivity to white and a matrix that leaves the mean response to white at 1.
/// Errors: ArgumentError for an M without inverse or without a positive response to white.
void set_colour_response(CameraProfile&, const Eigen::Matrix3d& M);

}  // namespace wheatstone
