#pragma once
// All devices of one rig behind their interfaces, with what is known about them beforehand.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/clock.h"
#include "core/rig_types.h"
#include "hardware/alignment_observer.h"
#include "hardware/device_error.h"
#include "hardware/led_array.h"
#include "hardware/linear_stage.h"
#include "hardware/marker_lights.h"
#include "hardware/panel_output.h"
#include "hardware/still_camera.h"

namespace wheatstone {

/// Refers to devices owned elsewhere, which must outlive it.
struct Rig {
  Clock& clock;
  LinearStage& stage;
  MarkerLights& markers;
  LedArray& leds;
  StillCamera& camera;
  AlignmentObserver& observer;
  std::array<PanelOutput*, 8> panels;  // at 2 * index_of(id) + (projector ? 1 : 0); never null

  CameraProfile camera_profile;
  std::vector<PanelModel> panel_models;  // at index_of(id)
  std::vector<Eigen::Vector3d> marker_positions_rsb_mm;
  std::vector<Eigen::Vector3d> near_cross_positions_rsb_mm;  // crosses on the near plane

  PanelOutput& panel(DisplayId id, PanelOutput::Modulator modulator) const {
    const bool projector = modulator == PanelOutput::Modulator::kProjector;
    return *panels[static_cast<std::size_t>(2 * index_of(id) + (projector ? 1 : 0))];
  }
};

}  // namespace wheatstone
