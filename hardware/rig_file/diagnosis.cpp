#include "hardware/rig_file/diagnosis.h"

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr Duration kOpenLimit = Duration::of(5);

}  // namespace

std::vector<DeviceDiagnosis> diagnose(const RigDescription& rig) {
  std::vector<DeviceDiagnosis> out;
  const auto look_at = [&](const char* role, const auto& plan) {
    if (!plan) return;
    DeviceDiagnosis d{role, plan->driver, plan->address, "ok", {}, ""};
    try {
      if (plan->open) {
        RigContext context{SteadyClock().in(kOpenLimit), nullptr, {}};
        d.identity = plan->open(context)->identity();
      } else {
        d.identity.driver = plan->driver;
      }
    } catch (const DeviceError& e) {
      d.status = to_string(e.kind());
      d.problem = e.what();
    } catch (const Error& e) {
      d.status = "wrong";
      d.problem = e.what();
    }
    out.push_back(std::move(d));
  };
  look_at("stage", rig.stage);
  look_at("platform", rig.platform);
  look_at("markers", rig.markers);
  look_at("leds", rig.leds);
  look_at("camera", rig.camera);
  look_at("video", rig.video);
  look_at("spectroradiometer", rig.spectroradiometer);
  look_at("head_tracker", rig.head_tracker);
  look_at("light_sensor", rig.light_sensor);
  return out;
}

}  // namespace wheatstone
