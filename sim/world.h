#pragma once
// The state of the digital twin, and the truth a test may compare against.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "core/geometry.h"
#include "core/image.h"
#include "core/rig_types.h"
#include "sim/faults.h"
#include "sim/panels.h"
#include "sim/scene.h"

namespace wheatstone {

inline constexpr double kStageTravelMm = 167;
inline constexpr double kStageStepsPerMm = 160;  // 1600 steps a turn of a 10 mm screw

/// What the two modulators of one display were last told to show.
struct PanelDrive {
  DriveImage lcd, projector;
};

/// Emulated devices act on it from threads of their own: they hold `mutex` while they do.
struct World {
  World(const std::string& scene_name, double scale, std::uint64_t seed);

  std::mutex mutex;
  std::uint64_t seed;
  std::string scene_name;
  double scale;
  Scene scene;
  SimulatedClock clock;
  FaultScript faults{clock};
  double carriage_mm = 0;  // where it really is
  double backlash_mm = 0;  // how far right of its encoder's reading it stands coming from above
  double platform_rad = 0;
  BoxLight light;
  std::array<PanelDrive, 4> panel_drives;  // at index_of(id)
  std::vector<PanelModel> panel_models;    // at index_of(id)
  CameraProfile camera_profile;

  /// The motor turns to `mm` (a whole number of steps) and the carriage settles, a few micrometres
  /// beside it; returns what an encoder on the motor reads then. Nothing moves if it stands there.
  /// Where it comes to rest depends on the position, the side it comes from and how often it came
  /// from there; not on what else was done, so that a session in two parts sees what one in a
  /// single part sees.
  double move_carriage(double mm);
  /// At the home switch: position 0.
  void home_carriage();

  PanelModel& model(DisplayId id) { return panel_models[static_cast<std::size_t>(index_of(id))]; }
  const PanelModel& model(DisplayId id) const {
    return panel_models[static_cast<std::size_t>(index_of(id))];
  }
  RgbImage panel_light(DisplayId id) const {
    const PanelDrive& d = panel_drives[static_cast<std::size_t>(index_of(id))];
    return panel_light_cd_m2(model(id), d.lcd, d.projector);
  }

 private:
  double commanded_mm_ = 0, encoder_mm_ = 0;
  std::map<std::pair<double, int>, std::uint64_t> visits_;
};

/// The still camera when its carriage stands at `carriage_mm`.
RigidTransform true_T_camera_rsb(double carriage_mm);
CameraProfile true_camera_profile(double scale);
/// Crosses on the near plane at which observers align.
std::vector<Eigen::Vector3d> near_cross_positions_rsb_mm();

}  // namespace wheatstone
