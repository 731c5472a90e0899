#include "hardware/rig_file/diagnosis.h"

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr Duration kOpenLimit = Duration::of(5);

}  // namespace

std::vector<DeviceDiagnosis> diagnose(const RigDescription& rig) {
  std::vector<DeviceDiagnosis> out;
  rig.for_each_kind([&](const char* role, const auto& plan) {
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
  });
  return out;
}

}  // namespace wheatstone
