#include "calib/marker_matching.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "calib/pnp.h"
#include "core/error.h"

namespace wheatstone {
namespace {

constexpr std::size_t kCandidates = 8;  // strongest blobs that may be a marker
// A true set fits to a few hundredths of a pixel, a false one misses by many pixels; between them
// lie a lens that is known badly and markers measured by hand.
constexpr double kFitPx = 2;
// The same for three markers seen by a camera that is taken to look straight into the box.
constexpr double kStraightFit = 0.02;  // of the markers' spread in the picture
constexpr const char* kNames[4] = {"bottom-left", "bottom-right", "top-left", "top-right"};

using Points = std::array<Eigen::Vector2d, 4>;

Points centres(const std::array<MarkerBlob, 4>& blobs) {
  Points p;
  for (std::size_t i = 0; i < 4; ++i) p[i] = blobs[i].centroid_px;
  return p;
}

/// Root mean square distance in px under the best pose; infinity when there is none, or when the
/// camera would stand behind the wall or upside down: a rectangle fits those as well.
double misfit_px(std::span<const Eigen::Vector3d> markers, const Points& seen, const Intrinsics& k,
                 const Distortion& d) {
  try {
    const RigidTransform T = pose_from_points(markers, seen, k, d, "");
    const bool in_front = camera_centre(T).z() > markers[0].z();
    const bool upright = (T.R * Eigen::Vector3d::UnitY()).y() < 0;
    if (!in_front || !upright) return std::numeric_limits<double>::infinity();
    double squares = 0;
    for (std::size_t i = 0; i < 4; ++i)
      squares += (project(k, d, T * markers[i]) - seen[i]).squaredNorm();
    return std::sqrt(squares / 4);
  } catch (const ArgumentError&) {
    return std::numeric_limits<double>::infinity();
  }
}

/// Two markers that must be exchanged to make sense of the frame, or an empty text.
std::string swapped(std::span<const Eigen::Vector3d> markers, const Points& seen,
                    const Intrinsics& k, const Distortion& d) {
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = a + 1; b < 4; ++b) {
      Points exchanged = seen;
      std::swap(exchanged[a], exchanged[b]);
      if (misfit_px(markers, exchanged, k, d) < kFitPx)
        return std::string("the ") + kNames[a] + " and " + kNames[b] + " LEDs are swapped";
    }
  return "";
}

/// The marker without which the others fit a camera that looks straight into the box, or -1.
/// Unknown is the camera's centre alone: linear in the normalised coordinates.
int missing(std::span<const Eigen::Vector3d> markers, const Points& seen, const Intrinsics& k,
            const Distortion& d) {
  const Eigen::Matrix3d R = straight_R_camera_rsb();
  int found = -1;
  for (int left_out = 0; left_out < 4; ++left_out) {
    Eigen::Matrix<double, 6, 3> A;
    Eigen::Matrix<double, 6, 1> b;
    int row = 0;
    double spread = 0;
    try {
      for (int i = 0; i < 4; ++i) {
        if (i == left_out) continue;
        const auto& px = seen[static_cast<std::size_t>(i)];
        const Eigen::Vector2d u =
            undistort(d, {(px.x() - k.cx_px) / k.fx_px, (px.y() - k.cy_px) / k.fy_px});
        const Eigen::Vector3d q = R * markers[static_cast<std::size_t>(i)];  // p = q + t
        for (int axis = 0; axis < 2; ++axis, ++row) {
          A.row(row).setZero();
          A(row, axis) = 1;
          A(row, 2) = -u[axis];
          b[row] = u[axis] * q.z() - q[axis];
        }
        spread = std::max(spread, (u - undistort(d, {(seen[0].x() - k.cx_px) / k.fx_px,
                                                     (seen[0].y() - k.cy_px) / k.fy_px}))
                                      .norm());
      }
    } catch (const ArgumentError&) {
      return -1;
    }
    const Eigen::Vector3d t = A.colPivHouseholderQr().solve(b);
    const double depth = t.z() + (R * markers[0]).z();
    const double misfit = (A * t - b).norm() / std::abs(depth);
    if (depth > 0 && misfit < kStraightFit * spread) {
      if (found >= 0) return -1;  // two explanations are none
      found = left_out;
    }
  }
  return found;
}

}  // namespace

std::array<MarkerBlob, 4> match_markers(std::span<const MarkerBlob> blobs,
                                        std::span<const Eigen::Vector3d> markers,
                                        const Intrinsics& k, const Distortion& d,
                                        const std::string& what) {
  if (markers.size() != 4)
    throw ArgumentError(what + ": " + std::to_string(markers.size()) + " marker positions",
                        "give those of the four marker LEDs");
  std::vector<MarkerBlob> strongest(blobs.begin(), blobs.end());
  std::sort(strongest.begin(), strongest.end(),
            [](const MarkerBlob& x, const MarkerBlob& y) { return x.signal_dn > y.signal_dn; });
  strongest.resize(std::min(strongest.size(), kCandidates));

  std::array<MarkerBlob, 4> best;
  double best_signal = 0;
  const auto n = strongest.size();
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = a + 1; b < n; ++b)
      for (std::size_t c = b + 1; c < n; ++c)
        for (std::size_t e = c + 1; e < n; ++e) {
          const std::array<MarkerBlob, 4> set = {strongest[a], strongest[b], strongest[c],
                                                 strongest[e]};
          const double signal =
              set[0].signal_dn + set[1].signal_dn + set[2].signal_dn + set[3].signal_dn;
          if (signal <= best_signal) continue;
          try {
            const auto ordered = order_markers(set, what);
            if (misfit_px(markers, centres(ordered), k, d) > kFitPx) continue;
            best = ordered;
            best_signal = signal;
          } catch (const ArgumentError&) {
            continue;  // not even a quadrilateral
          }
        }
  if (best_signal > 0) return best;

  const Points seen = centres(order_markers(strongest, what));  // throws in its own words
  std::string reason = swapped(markers, seen, k, d);
  if (reason.empty()) {
    const int gone = missing(markers, seen, k, d);
    if (gone >= 0)
      reason = std::string("the ") + kNames[gone] +
               " LED is missing or hidden, and another spot was taken for it";
  }
  if (!reason.empty())
    throw ArgumentError(what + ": " + reason,
                        "check the LEDs, their wiring and their positions, "
                        "and take the frame again");
  char misfit[60];
  std::snprintf(misfit, sizeof misfit, " (misfit %.1f px)", misfit_px(markers, seen, k, d));
  throw ArgumentError(
      what + ": no four spots stand where the marker LEDs should" + std::string(misfit),
      "remove reflections and other lights, or check the marker positions and the camera's "
      "intrinsics");
}

}  // namespace wheatstone
