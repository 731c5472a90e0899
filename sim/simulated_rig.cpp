#include "sim/simulated_rig.h"

#include <bit>
#include <cmath>
#include <map>
#include <sstream>
#include <utility>

#include "core/error.h"
#include "core/random.h"
#include "sim/camera.h"
#include "sim/observer.h"

namespace wheatstone {
namespace {

constexpr std::uint64_t kStageSeed = 0x7374616765ULL;  // apart from the camera's noise
constexpr double kSpeedMmS = 50, kSettleS = 0.5, kSettleSigmaMm = 0.005;
constexpr Nanoseconds kRefreshNs = 16'666'667;

class SimulatedStage final : public LinearStage {
 public:
  explicit SimulatedStage(World& world) : world_(world) {}

  Length travel() const override { return Length::of(kStageTravelMm); }

  Duration move_duration(Length distance) const override {
    return Duration::of(distance.value() / kSpeedMmS + kSettleS);
  }

  Length home(Deadline deadline) override {
    spend(world_.carriage_mm, deadline);
    homed_ = true;
    commanded_mm_ = world_.carriage_mm = 0;
    return Length::of(0);
  }

  Length move_to(Length target, Deadline deadline) override {
    const double mm = target.value();
    if (!homed_) {
      throw DeviceError(DeviceError::Kind::kNotHomed, "the stage does not know its position",
                        "home it first");
    }
    if (!(mm >= 0 && mm <= kStageTravelMm)) {
      std::ostringstream problem;
      problem << "position " << mm << " mm is beyond the stage's travel";
      throw DeviceError(DeviceError::Kind::kOutOfRange, problem.str(), "use 0 to 167 mm");
    }
    spend(std::abs(mm - world_.carriage_mm), deadline);
    // Where it comes to rest depends on the position, the side it comes from and how often it came
    // from there; not on what else was done, so that a session in two parts sees what one in a
    // single part sees.
    const int side = (mm > commanded_mm_) - (mm < commanded_mm_);
    RandomStream random(world_.seed ^ kStageSeed,
                        stream_of({std::bit_cast<std::uint64_t>(mm),
                                   static_cast<std::uint64_t>(side), visits_[{mm, side}]++}));
    commanded_mm_ = mm;
    const double settled_mm = mm + kSettleSigmaMm * random.normal();
    // The encoder sits on the motor and does not see the backlash.
    world_.carriage_mm = settled_mm + (side < 0 ? world_.backlash_mm : 0);
    return Length::of(settled_mm);
  }

  void stop() noexcept override {}  // moves are over when they return

 private:
  void spend(double distance_mm, Deadline deadline) {
    const Nanoseconds done = world_.clock.in(move_duration(Length::of(distance_mm))).at_ns;
    if (done > deadline.at_ns) {
      world_.clock.wait_until(deadline.at_ns);
      throw DeviceError(DeviceError::Kind::kTimeout, "the stage did not arrive in time",
                        "allow 5 s for a move");
    }
    world_.clock.wait_until(done);
  }

  World& world_;
  bool homed_ = false;
  double commanded_mm_ = 0;
  std::map<std::pair<double, int>, std::uint64_t> visits_;
};

class SimulatedMarkers final : public MarkerLights {
 public:
  explicit SimulatedMarkers(World& world) : world_(world) {}
  int count() const override { return kMarkerCount; }
  void set(int index, bool on) override {
    if (index < 0 || index >= kMarkerCount) {
      throw DeviceError(DeviceError::Kind::kOutOfRange,
                        "there is no marker " + std::to_string(index), "use 0 to 3");
    }
    const unsigned bit = 1U << index;
    world_.light.marker_mask =
        on ? world_.light.marker_mask | bit : world_.light.marker_mask & ~bit;
  }
  std::vector<Eigen::Vector3d> positions_rsb_mm() const override {
    const auto positions = marker_positions_rsb_mm();
    return {positions.begin(), positions.end()};
  }

 private:
  World& world_;
};

class SimulatedLeds final : public LedArray {
 public:
  explicit SimulatedLeds(World& world) : world_(world) {}
  void set_all(double drive) override {
    if (!(drive >= 0 && drive <= 1)) {
      throw DeviceError(DeviceError::Kind::kOutOfRange,
                        "LED drive " + std::to_string(drive) + " is not in [0, 1]",
                        "use 0 for off and 1 for full light");
    }
    world_.light.led_drive = drive;
  }

 private:
  World& world_;
};

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
  SimulatedMarkers markers{world};
  SimulatedLeds leds{world};
  SimulatedCamera camera;
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
  std::array<PanelOutput*, 8> panels{};
  for (std::size_t i = 0; i < panels.size(); ++i) panels[i] = d.panels[i].get();
  return {d.world.clock,
          d.stage,
          d.markers,
          d.leds,
          d.camera,
          d.observer,
          panels,
          d.world.camera_profile,
          d.world.panel_models,
          d.markers.positions_rsb_mm(),
          near_cross_positions_rsb_mm()};
}

}  // namespace wheatstone
