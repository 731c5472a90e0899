#pragma once
// The state of the digital twin, and the truth a test may compare against.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/geometry.h"
#include "core/image.h"
#include "core/rig_types.h"
#include "sim/panels.h"
#include "sim/scene.h"

namespace wheatstone {

inline constexpr double kStageTravelMm = 167;

/// What the two modulators of one display were last told to show.
struct PanelDrive {
  DriveImage lcd, projector;
};

struct World {
  World(const std::string& scene_name, double scale, std::uint64_t seed);

  std::uint64_t seed;
  std::string scene_name;
  double scale;
  Scene scene;
  SimulatedClock clock;
  double carriage_mm = 0;
  double backlash_mm = 0;  // how far right of its encoder's reading it stands coming from above
  BoxLight light;
  std::array<PanelDrive, 4> panel_drives;  // at index_of(id)
  std::vector<PanelModel> panel_models;    // at index_of(id)
  CameraProfile camera_profile;

  PanelModel& model(DisplayId id) { return panel_models[static_cast<std::size_t>(index_of(id))]; }
  const PanelModel& model(DisplayId id) const {
    return panel_models[static_cast<std::size_t>(index_of(id))];
  }
  RgbImage panel_light(DisplayId id) const {
    const PanelDrive& d = panel_drives[static_cast<std::size_t>(index_of(id))];
    return panel_light_cd_m2(model(id), d.lcd, d.projector);
  }
};

/// The still camera when its carriage stands at `carriage_mm`.
RigidTransform true_T_camera_rsb(double carriage_mm);
CameraProfile true_camera_profile(double scale);
/// Crosses on the near plane at which observers align.
std::vector<Eigen::Vector3d> near_cross_positions_rsb_mm();

}  // namespace wheatstone
