#include "hardware/rig_file/driver_catalogue.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <type_traits>

#include "hardware/serial/arduino_gantry.h"
#include "hardware/serial/grbl.h"

namespace wheatstone {

void DriverCatalogue::refuse(const TomlTable& table, const std::string& driver,
                             const std::vector<std::string>& known) const {
  if (const auto it = missing_.find(driver); it != missing_.end())
    table.fail("driver", fmt::format("names {}, which this program was built without", driver),
               fmt::format("install {} and build again", it->second));
  table.fail("driver", fmt::format("names no driver of this kind of device ({})", driver),
             fmt::format("use {}", fmt::join(known, ", ")));
}

namespace {

constexpr double kLongestRailMm = 10'000;

template <class P>
DevicePlan<Stage<P>> read_grbl(const TomlTable& table, const char* travel_key, double longest) {
  GrblSettings settings;
  settings.port = table.text("port");
  settings.baud = static_cast<int>(table.integer_or("baud", 115200, 9600, 921600));
  const std::string axis = table.text_or("axis", std::is_same_v<P, Angle> ? "Y" : "X");
  if (axis != "X" && axis != "Y") table.fail("axis", "must be \"X\" or \"Y\"");
  const GrblAxisSettings axis_settings{axis == "X" ? 0 : 1,
                                       table.number(travel_key, 1e-3, longest)};
  const auto open = [settings, axis_settings](RigContext& context) -> std::unique_ptr<Stage<P>> {
    std::shared_ptr<void>& shared = context.shared[settings.port.string()];
    if (!shared) {
      GrblSettings with_transcript = settings;
      with_transcript.transcript = context.transcript;
      shared = std::make_shared<GrblController>(with_transcript, context.deadline);
    }
    return std::make_unique<GrblAxis<P>>(std::static_pointer_cast<GrblController>(shared),
                                         axis_settings);
  };
  return {"", settings.port.string(), axis, open};
}

DevicePlan<LinearStage> read_arduino_gantry(const TomlTable& table) {
  ArduinoGantrySettings settings;
  settings.port = table.text("port");
  settings.travel_mm = table.number("travel_mm", 1e-3, kLongestRailMm);
  settings.full_scale = static_cast<int>(table.integer_or("full_scale", 100, 1, 121));
  settings.speed = static_cast<int>(table.integer_or("speed", 0, 0, 10));
  return {"", settings.port.string(), "",
          [settings](RigContext& context) -> std::unique_ptr<LinearStage> {
            ArduinoGantrySettings with_transcript = settings;
            with_transcript.transcript = context.transcript;
            return std::make_unique<ArduinoGantry>(with_transcript);
          }};
}

}  // namespace

void add_simulated_drivers(DriverCatalogue& catalogue) {
  const auto add = [&]<class D>(std::type_identity<D>) {
    catalogue.add<D>(kSimulatedDriver, [](const TomlTable&) { return DevicePlan<D>{}; });
  };
  add(std::type_identity<LinearStage>());
  add(std::type_identity<RotaryStage>());
  add(std::type_identity<MarkerLights>());
  add(std::type_identity<LedArray>());
  add(std::type_identity<StillCamera>());
  add(std::type_identity<VideoCamera>());
  add(std::type_identity<Spectroradiometer>());
  add(std::type_identity<HeadTracker>());
  add(std::type_identity<LightSensor>());
}

void add_serial_drivers(DriverCatalogue& catalogue) {
  catalogue.add<LinearStage>("grbl", [](const TomlTable& table) {
    return read_grbl<Length>(table, "travel_mm", kLongestRailMm);
  });
  catalogue.add<RotaryStage>(
      "grbl", [](const TomlTable& table) { return read_grbl<Angle>(table, "travel_deg", 360); });
  catalogue.add<LinearStage>("arduino-gantry", read_arduino_gantry);
}

}  // namespace wheatstone
