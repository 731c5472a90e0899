#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/commands/commands.h"
#include "apps/rig_source.h"
#include "core/error.h"
#include "hardware/rig_file/diagnosis.h"
#ifdef WHEATSTONE_HAS_GPHOTO2
#include "hardware/still/gphoto_camera.h"
#endif
#include "rendering/gl/offscreen.h"

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

/// Still cameras on USB that no device of the rig file is.
json other_still_cameras([[maybe_unused]] const std::vector<DeviceDiagnosis>& devices) {
  json out = json::array();
#ifdef WHEATSTONE_HAS_GPHOTO2
  for (const StillCameraFound& camera : list_still_cameras()) {
    const bool ours = std::any_of(devices.begin(), devices.end(), [&](const DeviceDiagnosis& d) {
      return d.status == "ok" && d.driver == "gphoto2" && d.identity.serial == camera.serial;
    });
    if (ours) continue;
    json line = {{"model", camera.model}, {"address", camera.address}, {"serial", camera.serial}};
    if (!camera.trouble.empty()) line["problem"] = camera.trouble;
    out.push_back(line);
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
                 {"other_serial_lines", other_serial_lines(rig)}};
  int wrong = report["opengl"]["status"] != "ok";
  const std::vector<DeviceDiagnosis> devices = diagnose(rig);
  report["other_still_cameras"] = other_still_cameras(devices);
  for (const DeviceDiagnosis& d : devices) {
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
    for (const json& c : report["other_still_cameras"])
      fmt::print("{:18} {:12} {} at {}, {}\n", "still camera", "not named", text(c, "model"),
                 text(c, "address"),
                 c.contains("problem") ? text(c, "problem") : "serial " + text(c, "serial"));
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
