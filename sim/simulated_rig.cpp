#include "sim/simulated_rig.h"

#include <algorithm>
#include <sstream>

#include "core/error.h"
#include "sim/camera.h"
#include "sim/head_tracker.h"
#include "sim/light_sensor.h"
#include "sim/lights.h"
#include "sim/observer.h"
#include "sim/spectroradiometer.h"
#include "sim/stage.h"
#include "sim/video_camera.h"

namespace wheatstone {
namespace {

constexpr Nanoseconds kRefreshNs = 16'666'667;
constexpr Duration kShowLimit = Duration::of(1);

class SimulatedPanel final : public PanelOutput {
 public:
  SimulatedPanel(World& world, DisplayId id, Modulator modulator)
      : world_(world), id_(id), modulator_(modulator) {}

  DisplayId id() const override { return id_; }
  Modulator modulator() const override { return modulator_; }
  int width_px() const override {
    const PanelModel& m = world_.model(id_);
    return modulator_ == Modulator::kLcd ? m.lcd_width_px : m.projector_width_px;
  }
  int height_px() const override {
    const PanelModel& m = world_.model(id_);
    return modulator_ == Modulator::kLcd ? m.lcd_height_px : m.projector_height_px;
  }

  PresentRecord show(const DriveImage& drive, Nanoseconds at) override {
    world_.faults.meet("displays", world_.clock.in(kShowLimit));
    const bool lcd = modulator_ == Modulator::kLcd;
    if (drive.width() != width_px() || drive.height() != height_px() ||
        drive.codes.type() != (lcd ? CV_8UC3 : CV_8UC1)) {
      std::ostringstream remedy;
      remedy << "send " << width_px() << " x " << height_px() << " pixels of " << (lcd ? 3 : 1)
             << " channel(s) of 8 bits";
      throw DeviceError(DeviceError::Kind::kRefused,
                        "a frame does not fit the " + std::string(lcd ? "LCD" : "projector") +
                            " of display " + to_string(id_),
                        remedy.str());
    }
    const Nanoseconds from = std::max(at, world_.clock.now_ns());
    PresentRecord record;
    record.asked_ns = at;
    record.achieved_ns = (from + kRefreshNs - 1) / kRefreshNs * kRefreshNs;
    record.late = record.achieved_ns - at >= kRefreshNs;
    world_.clock.wait_until(record.achieved_ns);
    PanelDrive& shown = world_.panel_drives[static_cast<std::size_t>(index_of(id_))];
    (lcd ? shown.lcd : shown.projector).codes = drive.codes.clone();
    return record;
  }

  void go_dark() noexcept override {
    PanelDrive& shown = world_.panel_drives[static_cast<std::size_t>(index_of(id_))];
    (modulator_ == Modulator::kLcd ? shown.lcd : shown.projector).codes.setTo(0);
  }

 private:
  World& world_;
  DisplayId id_;
  Modulator modulator_;
};

}  // namespace

struct SimulatedRig::Devices {
  explicit Devices(const SimulatedRigOptions& o)
      : world(o.scene, o.scale, o.seed),
        camera(world, o.camera_noise),
        video(world, o.camera_noise),
        observer(world, o.observer_noise_arcmin) {
    for (const DisplayId id : kDisplays) {
      for (const auto modulator :
           {PanelOutput::Modulator::kLcd, PanelOutput::Modulator::kProjector}) {
        panels.push_back(std::make_unique<SimulatedPanel>(world, id, modulator));
      }
    }
  }

  World world;
  SimulatedStage stage{world};
  SimulatedPlatform platform{world};
  SimulatedMarkers markers{world};
  SimulatedLeds leds{world};
  SimulatedCamera camera;
  SimulatedVideoCamera video;
  SimulatedHeadTracker head_tracker{world};
  SimulatedLightSensor light_sensor{world, kDisplays[0]};
  SimulatedSpectroradiometer spectroradiometer{world};
  SimulatedObserver observer;
  std::vector<std::unique_ptr<SimulatedPanel>> panels;  // in the order of Rig::panels
};

SimulatedRig::SimulatedRig(const SimulatedRigOptions& options) {
  if (!(options.observer_noise_arcmin >= 0)) {
    throw ArgumentError("the observer's noise is negative", "use 0 or more arcmin");
  }
  devices_ = std::make_unique<Devices>(options);
}

SimulatedRig::~SimulatedRig() = default;

World& SimulatedRig::world() {
  return devices_->world;
}

Rig SimulatedRig::rig() {
  Devices& d = *devices_;
  Rig rig(d.world.clock);
  rig.stage = d.stage;
  rig.platform = d.platform;
  rig.markers = d.markers;
  rig.leds = d.leds;
  rig.camera = d.camera;
  rig.video = d.video;
  rig.head_tracker = d.head_tracker;
  rig.light_sensor = d.light_sensor;
  rig.spectroradiometer = d.spectroradiometer;
  rig.observer = d.observer;
  for (std::size_t i = 0; i < rig.panels.size(); ++i) rig.panels[i] = d.panels[i].get();
  rig.camera_profile = d.world.camera_profile;
  rig.panel_models = d.world.panel_models;
  const auto markers = marker_positions_rsb_mm();
  rig.marker_positions_rsb_mm.assign(markers.begin(), markers.end());
  rig.near_cross_positions_rsb_mm = near_cross_positions_rsb_mm();
  return rig;
}

}  // namespace wheatstone
