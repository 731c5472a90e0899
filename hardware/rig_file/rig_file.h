#pragma once
// The rig file: which devices a rig has and what is known about them (docs/rig_file.md).

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hardware/display_outputs.h"
#include "hardware/rig.h"
#include "hardware/rig_file/driver_catalogue.h"

namespace wheatstone {

/// A rig file that has been read and found in order; nothing has been opened.
struct RigDescription {
  std::filesystem::path file;
  std::string name;

  std::optional<DevicePlan<LinearStage>> stage;
  std::optional<DevicePlan<RotaryStage>> platform;
  std::optional<DevicePlan<MarkerLights>> markers;
  std::optional<DevicePlan<LedArray>> leds;
  std::optional<DevicePlan<StillCamera>> camera;
  std::optional<DevicePlan<VideoCamera>> video;
  std::optional<DevicePlan<Spectroradiometer>> spectroradiometer;
  std::optional<DevicePlan<HeadTracker>> head_tracker;
  std::optional<DevicePlan<LightSensor>> light_sensor;
  std::optional<DevicePlan<DisplayOutputs>> display_outputs;
  std::vector<WantedOutput> outputs;

  std::optional<std::filesystem::path> camera_profile;  // camera.json
  std::optional<std::filesystem::path> displays;        // displays.json
  std::vector<Eigen::Vector3d> marker_positions_rsb_mm, near_cross_positions_rsb_mm;

  Luminance luminance_limit;  // at the observer's eye
  Duration watchdog;          // the rig is made safe when the program hangs for so long

  // Moves by hand beyond these have to be confirmed.
  std::optional<std::array<Length, 2>> soft_stage;
  std::optional<std::array<Angle, 2>> soft_platform;

  /// The twin behind drivers named "simulated".
  struct Simulation {
    std::string scene = "card";
    double scale = 0.25;
    std::uint64_t seed = 7;
  } simulation;

  /// Calls visit("stage", stage), ... for all kinds of device, there or not, in the order of the
  /// file's manual.
  template <class Visit>
  void for_each_kind(const Visit& visit) const {
    visit("stage", stage);
    visit("platform", platform);
    visit("markers", markers);
    visit("leds", leds);
    visit("camera", camera);
    visit("video", video);
    visit("spectroradiometer", spectroradiometer);
    visit("head_tracker", head_tracker);
    visit("light_sensor", light_sensor);
    visit("display_outputs", display_outputs);
  }

  /// "stage", "markers", ... with driver and address, in the order of the file's manual.
  struct Line {
    std::string role, driver, address;
  };
  std::vector<Line> devices() const;
  bool simulated() const;
};

/// Errors: FileError naming file, line and key: syntax, unknown keys and drivers, wrong kinds and
/// units, values out of range, two devices at one address, missing calibration files, simulated and
/// real devices in one rig (they have no clock in common).
RigDescription read_rig_file(const std::filesystem::path&, const DriverCatalogue&);

/// The devices of a rig, opened, and what holds them.
class OpenRig {
 public:
  /// Opens all devices, or none: throws what the first one says that does not open. `clock` must
  /// outlive it.
  OpenRig(const RigDescription&, Clock& clock, RigContext context);

  Rig rig();
  VideoCamera* video() { return video_.get(); }
  Spectroradiometer* spectroradiometer() { return spectroradiometer_.get(); }
  HeadTracker* head_tracker() { return head_tracker_.get(); }
  LightSensor* light_sensor() { return light_sensor_.get(); }
  DisplayOutputs* display_outputs() { return display_outputs_.get(); }

 private:
  Clock& clock_;
  RigDescription description_;
  RigContext context_;
  std::unique_ptr<LinearStage> stage_;
  std::unique_ptr<RotaryStage> platform_;
  std::unique_ptr<MarkerLights> markers_;
  std::unique_ptr<LedArray> leds_;
  std::unique_ptr<StillCamera> camera_;
  std::unique_ptr<VideoCamera> video_;
  std::unique_ptr<Spectroradiometer> spectroradiometer_;
  std::unique_ptr<HeadTracker> head_tracker_;
  std::unique_ptr<LightSensor> light_sensor_;
  std::unique_ptr<DisplayOutputs> display_outputs_;
};

}  // namespace wheatstone
