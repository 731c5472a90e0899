#pragma once
// What the camera centres say about the rail that carried the camera.

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

namespace wheatstone {

struct RailReport {
  Eigen::Vector3d direction_rsb =
      Eigen::Vector3d::UnitX();  // unit length, towards larger positions
  /// Distance of the centres from the best line.
  double straightness_rms_mm = 0, straightness_largest_mm = 0;
  double pitch_mm = 0;  // mean distance between neighbouring views along the line
  /// Travel along the line for each mm asked for; the deviations below have it taken out.
  double scale = 1;
  double step_error_rms_mm = 0, step_error_largest_mm = 0;
  /// Per view: from the foot on the line to the centre, in rsb, and the excess travel along it.
  std::vector<Eigen::Vector3d> off_line_mm;
  std::vector<double> step_error_mm;
};

/// Line by total least squares. `positions_mm` are what the rail says of each view (encoder or
/// commanded), in `gantry`. Throws ArgumentError unless there is a position per centre, and at
/// least two views at different positions.
RailReport report_rail(std::span<const Eigen::Vector3d> centres_rsb,
                       std::span<const double> positions_mm);

/// A view that does not stand where the rail says, both on the rail's own scale.
struct MisplacedView {
  std::size_t view = 0;
  double seen_mm = 0, reported_mm = 0;  // by its centre, and by the rail
};

/// Views whose centre is more than `tolerance_mm` along the rail away from their position. The
/// rail's scale, offset and direction are those that most views agree on, so that no view that is
/// wrong has a say. Empty for fewer than three views or when all have one position.
/// Throws ArgumentError when the rest is no majority or three views contradict (nobody can say
/// which is wrong), when the centres stay in place while the positions change, and for lists of
/// different lengths.
std::vector<MisplacedView> misplaced_views(std::span<const Eigen::Vector3d> centres_rsb,
                                           std::span<const double> positions_mm,
                                           double tolerance_mm);

}  // namespace wheatstone
