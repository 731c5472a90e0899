#include "hardware/rig_file/diagnosis.h"

#include <fmt/format.h>

#include <utility>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr Duration kOpenLimit = Duration::of(5);

/// Runs `look`; what it throws becomes status and problem.
template <class Look>
void note(DeviceDiagnosis& d, const Look& look) {
  try {
    look();
  } catch (const DeviceError& e) {
    d.status = to_string(e.kind());
    d.problem = e.what();
  } catch (const Error& e) {
    d.status = "wrong";
    d.problem = e.what();
  }
}

/// One line per wanted display.
void diagnose_outputs(const RigDescription& rig, std::vector<DeviceDiagnosis>& out) {
  if (rig.outputs.empty()) return;
  std::vector<DisplayOutput> outputs;
  std::vector<OutputProblem> problems;
  DeviceDiagnosis all;
  note(all, [&] {
    if (!rig.display_outputs)
      throw DeviceError(DeviceError::Kind::kNotReady,
                        "the rig file does not say how its displays are reached",
                        "add [display_outputs] with driver = \"xrandr\"");
    RigContext context{SteadyClock().in(kOpenLimit), nullptr, {}};
    outputs = rig.display_outputs->open(context)->enumerate(context.deadline);
    problems = verify(outputs, rig.outputs);
  });
  for (const WantedOutput& wanted : rig.outputs) {
    DeviceDiagnosis d = all;
    d.role = "output " + wanted.role;
    d.driver = rig.display_outputs ? rig.display_outputs->driver : "";
    d.address = wanted.connector;
    if (all.problem.empty()) d.status = "ok";
    if (const DisplayOutput* output = find_output(outputs, wanted))
      d.identity.model = describe(*output);
    for (const OutputProblem& p : problems) {
      if (p.role != wanted.role) continue;
      d.status = "wrong";
      d.problem +=
          fmt::format("{}{}: {}; {}", d.problem.empty() ? "" : "\n", p.check, p.found, p.remedy);
    }
    out.push_back(std::move(d));
  }
}

}  // namespace

std::vector<DeviceDiagnosis> diagnose(const RigDescription& rig) {
  std::vector<DeviceDiagnosis> out;
  rig.for_each_kind([&](const char* role, const auto& plan) {
    if (!plan) return;
    DeviceDiagnosis d{role, plan->driver, plan->address, "ok", {}, ""};
    note(d, [&] {
      if (plan->open) {
        RigContext context{SteadyClock().in(kOpenLimit), nullptr, {}};
        d.identity = plan->open(context)->identity();
      } else {
        d.identity.driver = plan->driver;
      }
    });
    out.push_back(std::move(d));
  });
  diagnose_outputs(rig, out);
  return out;
}

}  // namespace wheatstone
