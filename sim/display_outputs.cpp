#include "sim/display_outputs.h"

namespace wheatstone {
namespace {

constexpr double kRefreshHz = 60;

struct Place {
  std::string role;
  DisplayOutput output;
};

std::vector<Place> places() {
  std::vector<Place> out;
  int x_px = 0;
  const auto add = [&](const std::string& role, const EdidIdentity& edid, int width, int height) {
    DisplayOutput o;
    o.connector = "SIM-" + std::to_string(out.size() + 1);
    o.edid = edid;
    o.x_px = x_px;
    o.width_px = width;
    o.height_px = height;
    o.refresh_hz = kRefreshHz;
    o.bits_per_channel = 8;
    o.gamma_size = 256;
    o.gamma_is_identity = false;  // a desktop's colour management has been at work
    x_px += width;
    out.push_back({role, o});
  };
  std::uint32_t serial = 100;
  for (const DisplayId id : kDisplays) {
    add(to_string(id) + "_lcd", {"WST", 1, ++serial, "LCD", ""}, 2048, 1536);
    add(to_string(id) + "_projector", {"WST", 2, 1, "PROJECTOR", ""}, 1024, 768);
  }
  add("operator", {"WST", 3, 9, "DESK", "D-9"}, 1920, 1080);
  return out;
}

}  // namespace

SimulatedDisplayOutputs::SimulatedDisplayOutputs() {
  for (const Place& place : places()) outputs.push_back(place.output);
}

SimulatedDisplayOutputs::SimulatedDisplayOutputs(World& world) : SimulatedDisplayOutputs() {
  faults_ = &world.faults;
}

std::vector<DisplayOutput> SimulatedDisplayOutputs::enumerate(Deadline deadline) {
  if (faults_) faults_->meet("display outputs", deadline);
  return outputs;
}

void SimulatedDisplayOutputs::neutralise(Deadline deadline) {
  if (faults_) faults_->meet("display outputs", deadline);
  for (DisplayOutput& o : outputs) o.gamma_is_identity = true;
}

std::vector<WantedOutput> wanted_simulated_outputs() {
  std::vector<WantedOutput> out;
  for (const Place& place : places()) {
    const DisplayOutput& o = place.output;
    const bool cloned = o.edid.name == "PROJECTOR";
    out.push_back({place.role, o.edid, cloned ? o.connector : "", o.width_px, o.height_px,
                   o.refresh_hz, o.bits_per_channel});
  }
  return out;
}

void add_simulated_outputs_driver(DriverCatalogue& catalogue) {
  catalogue.add<DisplayOutputs>(kSimulatedDriver, [](const TomlTable&) {
    DevicePlan<DisplayOutputs> plan;
    plan.open = [](RigContext& context) {
      auto outputs = std::make_unique<SimulatedDisplayOutputs>();
      outputs->neutralise(context.deadline);  // no desktop has been at work there
      return outputs;
    };
    return plan;
  });
}

}  // namespace wheatstone
