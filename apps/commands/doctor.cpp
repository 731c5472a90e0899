#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/commands/commands.h"
#include "apps/drivers.h"
#include "core/error.h"
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

void doctor(const std::string& file, bool as_json) {
  const RigDescription rig = read_rig_file(file, all_drivers());
  json report = {{"schema", "wheatstone-doctor/1"},
                 {"rig", rig.name},
                 {"opengl", graphics()},
                 {"devices", json::array()}};
  int wrong = report["opengl"]["status"] != "ok";
  const std::vector<DeviceDiagnosis> devices = diagnose(rig);
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
  report["other_devices"] = json::array();
  for (const OtherDevice& o : other_devices(rig, devices))
    report["other_devices"].push_back(
        {{"what", o.what}, {"address", o.address}, {"problem", o.problem}});
  if (as_json) {
    fmt::print("{}\n", report.dump(2));
  } else {
    const auto text = [](const json& j, const char* key) { return j.value(key, std::string()); };
    const json& gl = report["opengl"];
    fmt::print("{:28} {:12} {}\n", "OpenGL", text(gl, "status"),
               gl.contains("problem") ? text(gl, "problem")
                                      : text(gl, "version") + " on " + text(gl, "renderer"));
    for (const json& d : report["devices"])
      fmt::print("{:28} {:12} {}\n", text(d, "role"), text(d, "status"),
                 d.contains("problem")
                     ? text(d, "problem")
                     : fmt::format("{}{}{}{}", text(d, "driver"),
                                   text(d, "address").empty() ? "" : " at " + text(d, "address"),
                                   text(d, "model").empty() ? "" : ", " + text(d, "model"),
                                   text(d, "firmware").empty() ? "" : " " + text(d, "firmware")));
    for (const json& o : report["other_devices"])
      fmt::print("{:28} {:12} {}{}{}\n", text(o, "what"), "not named", text(o, "address"),
                 text(o, "problem").empty() ? "" : ": ", text(o, "problem"));
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
  command->add_flag("--json", *as_json, "the result as JSON on standard output");
  command->footer("Example:\n  wheatstone doctor --rig rigs/simulated.toml");
  command->callback([=] { doctor(*rig, *as_json); });
}

}  // namespace wheatstone::apps
