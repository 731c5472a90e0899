#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/commands/commands.h"
#include "apps/rig_source.h"
#include "core/error.h"
#include "hardware/rig_file/diagnosis.h"
#include "rendering/gl/offscreen.h"

#ifdef WHEATSTONE_HAS_HIDAPI
#include "hardware/hid/hid_drivers.h"
#endif

namespace wheatstone::apps {
namespace {

using nlohmann::json;

json graphics() {
  try {
    const OffscreenContext context;
    return {{"status", "ok"}, {"version", context.version()}, {"renderer", context.renderer()}};
  } catch (const GraphicsError& e) {
    return {{"status", "wrong"}, {"problem", e.what()}};
  }
}

/// Serial lines that no device of the rig file has, by their stable names.
std::vector<std::string> other_serial_lines(const RigDescription& rig) {
  std::vector<std::string> out;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/dev/serial/by-id", none)) {
    bool ours = false;
    for (const auto& device : rig.devices())
      ours = ours || std::filesystem::equivalent(device.address, entry.path(), none);
    if (!ours) out.push_back(entry.path().string());
  }
  return out;
}

/// Marker lights that are plugged in and that no device of the rig file is.
json other_lights([[maybe_unused]] const RigDescription& rig) {
  json out = json::array();
#ifdef WHEATSTONE_HAS_HIDAPI
  for (const HidLightFound& light : list_hid_lights()) {
    bool ours = false;
    for (const auto& device : rig.devices()) ours = ours || device.address == light.address;
    if (!ours)
      out.push_back({{"address", light.address}, {"node", light.node}, {"problem", light.problem}});
  }
#endif
  return out;
}

void doctor(const std::string& file, bool as_json) {
  const RigDescription rig = read_rig_file(file, all_drivers());
  json report = {{"schema", "wheatstone-doctor/1"},
                 {"rig", rig.name},
                 {"opengl", graphics()},
                 {"devices", json::array()},
                 {"other_serial_lines", other_serial_lines(rig)},
                 {"other_lights", other_lights(rig)}};
                 {"other_usb_devices", other_usb_devices(rig)}};
  int wrong = report["opengl"]["status"] != "ok";
  for (const DeviceDiagnosis& d : diagnose(rig)) {
    wrong += d.status != "ok";
    json line = {
        {"role", d.role}, {"driver", d.driver}, {"address", d.address}, {"status", d.status}};
    if (d.status == "ok")
      line.update({{"model", d.identity.model},
                   {"serial", d.identity.serial},
                   {"firmware", d.identity.firmware}});
    else
      line["problem"] = d.problem;
    report["devices"].push_back(line);
  }
  if (as_json) {
    fmt::print("{}\n", report.dump(2));
  } else {
    const auto text = [](const json& j, const char* key) { return j.value(key, std::string()); };
    const json& gl = report["opengl"];
    fmt::print("{:18} {:12} {}\n", "OpenGL", text(gl, "status"),
               gl.contains("problem") ? text(gl, "problem")
                                      : text(gl, "version") + " on " + text(gl, "renderer"));
    for (const json& d : report["devices"])
      fmt::print("{:18} {:12} {}\n", text(d, "role"), text(d, "status"),
                 d.contains("problem")
                     ? text(d, "problem")
                     : fmt::format("{}{}{}{}", text(d, "driver"),
                                   text(d, "address").empty() ? "" : " at " + text(d, "address"),
                                   text(d, "model").empty() ? "" : ", " + text(d, "model"),
                                   text(d, "firmware").empty() ? "" : " " + text(d, "firmware")));
    for (const json& line : report["other_serial_lines"])
      fmt::print("{:18} {:12} {}\n", "serial line", "not named", line.get<std::string>());
    for (const json& light : report["other_lights"])
      fmt::print("{:18} {:12} {} on {}{}\n", "marker light", "not named",
                 text(light, "address").empty() ? "one" : text(light, "address"),
                 text(light, "node"),
                 text(light, "problem").empty() ? "" : ": " + text(light, "problem"));
    for (const json& device : report["other_usb_devices"])
      fmt::print("{:18} {:12} {}\n", "USB device", "not named", device.get<std::string>());
  }
  if (wrong > 0)
    throw ArgumentError(
        fmt::format("{} of the rig's parts {} not work", wrong, wrong == 1 ? "does" : "do"),
        "see the lines above");
}

}  // namespace

void add_doctor(CLI::App& app) {
  auto* command = app.add_subcommand(
      "doctor", "Which devices of a rig answer, and what to do about those that do not");
  auto rig = std::make_shared<std::string>();
  auto as_json = std::make_shared<bool>(false);
  command->add_option("--rig", *rig, "rig file")->required();
  command->add_flag("--json", *as_json, "one JSON object on standard output");
  command->footer("Example:\n  wheatstone doctor --rig rigs/simulated.toml");
  command->callback([=] { doctor(*rig, *as_json); });
}

}  // namespace wheatstone::apps
