#pragma once
// Where eyes are and look, from video of pupils and corneal reflections.

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry.h"
#include "core/rig_types.h"
#include "hardware/device.h"

namespace wheatstone {

/// The camera and the infrared lights of a tracker. With two lights or more the cornea's centre
/// follows from the reflections; with one there is none.
struct EyeTrackerGeometry {
  Intrinsics intrinsics;
  Distortion distortion;
  RigidTransform T_camera_rsb;
  std::vector<Eigen::Vector3d> lights_rsb_mm;
};

/// A spherical cornea before a pupil, after Guestrin and Eizenman (2006). The angles turn the
/// optical axis into the visual one.
struct EyeModel {
  double cornea_radius_mm = 7.8;  // R
  double pupil_depth_mm = 4.2;    // K, from the cornea's centre to the pupil's
  double aqueous_index = 1.3375;
  Angle alpha, beta;  // sideways, upwards
};

struct TrackedEye {
  EyeCentre cornea;                             // centre of curvature of the cornea
  std::optional<Eigen::Vector3d> pupil_rsb_mm;  // its centre
  std::optional<Eigen::Vector3d> gaze_rsb;      // unit vector; only of calibrated subjects
};

enum class EyeState { kSeen, kBlink, kLost };

struct TrackedEyes {
  std::array<EyeState, 2> state = {EyeState::kLost, EyeState::kLost};  // left, right
  std::array<std::optional<TrackedEye>, 2> eyes;                       // where kSeen
  Nanoseconds time_ns = 0;  // mid-exposure, on the machine's monotonic clock
};

/// A tracker that computes from video; a plain stream of eye centres is a HeadTracker.
class EyeTracker : public Device {
 public:
  /// Throws ArgumentError for less than two lights or intrinsics of no size. Forgets the subject.
  virtual void calibrate(const EyeTrackerGeometry&) = 0;
  /// The observer looks at one target after the other; returns the model of each eye. Throws
  /// kNotReady without a geometry, kTooDark or kTooBright if the reflections are not seen,
  /// kTimeout.
  virtual std::array<EyeModel, 2> calibrate_subject(std::span<const Eigen::Vector3d> targets_rsb_mm,
                                                    Deadline) = 0;
  /// The next picture's. Nothing is smoothed across a blink. Throws kNotReady without a geometry.
  virtual TrackedEyes next(Deadline) = 0;
};

}  // namespace wheatstone
