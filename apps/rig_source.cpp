#include "apps/rig_source.h"

namespace wheatstone::apps {
namespace {

constexpr Duration kOpenLimit = Duration::of(10);

template <class D>
void keep_if(bool described, Fitted<D>& device, const char* what) {
  if (!described) device = Fitted<D>(what);
}

}  // namespace

RigSource::RigSource(const SimulatedRigOptions& options)
    : simulation_(options), twin_(std::make_unique<SimulatedRig>(options)) {}

RigSource::RigSource(const RigDescription& description, const std::filesystem::path& transcript)
    : name_(description.name), watchdog_(description.watchdog), description_(description) {
  if (description.simulated()) {
    const auto& s = description.simulation;
    simulation_ = {s.scene, s.scale, s.seed};
    twin_ = std::make_unique<SimulatedRig>(simulation_);
  } else {
    simulation_.scene.clear();
    simulation_.scale = 1;
    simulation_.seed = 0;
    open_ = std::make_unique<OpenRig>(
        description, clock_,
        RigContext{clock_.in(kOpenLimit),
                   transcript.empty() ? nullptr : std::make_shared<Transcript>(transcript),
                   {}});
  }
}

Rig RigSource::rig() {
  if (open_) return open_->rig();
  Rig rig = twin_->rig();
  if (description_.file.empty()) return rig;
  rig.luminance_limit = description_.luminance_limit;
  keep_if(description_.stage.has_value(), rig.stage, "camera rail");
  keep_if(description_.platform.has_value(), rig.platform, "turning platform");
  keep_if(description_.markers.has_value(), rig.markers, "marker lights");
  keep_if(description_.leds.has_value(), rig.leds, "LED array");
  keep_if(description_.camera.has_value(), rig.camera, "still camera");
  keep_if(description_.spectroradiometer.has_value(), rig.spectroradiometer, "spectroradiometer");
  return rig;
}

}  // namespace wheatstone::apps
