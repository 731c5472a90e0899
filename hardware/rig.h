#pragma once
// All devices of one rig behind their interfaces, with what is known about them beforehand.

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/rig_types.h"
#include "hardware/alignment_observer.h"
#include "hardware/device_error.h"
#include "hardware/head_tracker.h"
#include "hardware/led_array.h"
#include "hardware/light_sensor.h"
#include "hardware/marker_lights.h"
#include "hardware/panel_output.h"
#include "hardware/spectroradiometer.h"
#include "hardware/stage.h"
#include "hardware/still_camera.h"
#include "hardware/video_camera.h"

namespace wheatstone {

/// A device that a rig may lack. Using one that is lacking throws DeviceError kNotFound.
template <class D>
class Fitted {
 public:
  explicit Fitted(const char* what) : what_(what) {}
  Fitted& operator=(D& device) {
    device_ = &device;
    return *this;
  }
  explicit operator bool() const { return device_ != nullptr; }
  D& operator*() const {
    if (!device_)
      throw DeviceError(DeviceError::Kind::kNotFound, std::string("this rig has no ") + what_,
                        "name one in the rig file");
    return *device_;
  }
  D* operator->() const { return &**this; }

 private:
  const char* what_;
  D* device_ = nullptr;
};

/// Refers to devices owned elsewhere, which must outlive it.
struct Rig {
  explicit Rig(Clock& c) : clock(c) {}

  Clock& clock;
  Fitted<LinearStage> stage{"camera rail"};
  Fitted<RotaryStage> platform{"turning platform"};
  Fitted<MarkerLights> markers{"marker lights"};
  Fitted<LedArray> leds{"LED array"};
  Fitted<StillCamera> camera{"still camera"};
  Fitted<VideoCamera> video{"video camera"};
  Fitted<Spectroradiometer> spectroradiometer{"spectroradiometer"};
  Fitted<HeadTracker> head_tracker{"head tracker"};
  Fitted<LightSensor> light_sensor{"light sensor"};
  Fitted<AlignmentObserver> observer{"alignment observer"};
  std::array<PanelOutput*, 8> panels{};  // at 2 * index_of(id) + (projector ? 1 : 0); null: lacking

  /// What an eye may be shown at most; nothing: no limit is known.
  std::optional<Luminance> luminance_limit;

  CameraProfile camera_profile;
  std::vector<PanelModel> panel_models;  // at index_of(id)
  std::vector<Eigen::Vector3d> marker_positions_rsb_mm;
  std::vector<Eigen::Vector3d> near_cross_positions_rsb_mm;  // crosses on the near plane

  PanelOutput& panel(DisplayId id, PanelOutput::Modulator modulator) const {
    const bool projector = modulator == PanelOutput::Modulator::kProjector;
    PanelOutput* output = panels[static_cast<std::size_t>(2 * index_of(id) + (projector ? 1 : 0))];
    if (!output)
      throw DeviceError(DeviceError::Kind::kNotFound, "this rig has no display " + to_string(id),
                        "name one in the rig file");
    return *output;
  }
};

/// Stops what moves and darkens what shines, as far as the devices answer.
void make_safe(const Rig&) noexcept;

/// Leaves the rig safe, however the block ends.
class SafeAtExit {
 public:
  explicit SafeAtExit(const Rig& rig) : rig_(rig) {}
  ~SafeAtExit() { make_safe(rig_); }
  SafeAtExit(const SafeAtExit&) = delete;
  SafeAtExit& operator=(const SafeAtExit&) = delete;

 private:
  const Rig& rig_;
};

}  // namespace wheatstone
