#include "hardware/argyll/spotread.h"
#include "hardware/rig_file/driver_catalogue.h"
#include "hardware/serial/jeti.h"

namespace wheatstone {
namespace {

DevicePlan<Spectroradiometer> read_jeti(const TomlTable& table) {
  JetiSettings settings;
  settings.line = table.text("port");
  settings.baud = static_cast<int>(table.integer_or("baud", settings.baud, 0, 921600));
  if (settings.baud != 0 && settings.baud != 38400 && settings.baud != 115200 &&
      settings.baud != 921600)
    table.fail("baud", "must be 921600, 115200, 38400, or 0 to find out");
  settings.serial = table.text_or("serial", "");
  settings.floor_cd_m2 = table.number_or("floor_cd_m2", settings.floor_cd_m2, 0, 1000);
  return {"", settings.line.string(), "",
          [settings](RigContext& context) -> std::unique_ptr<Spectroradiometer> {
            return std::make_unique<Jeti>(settings, context.transcript);
          }};
}

DevicePlan<Spectroradiometer> read_spotread(const TomlTable& table) {
  SpotreadSettings settings;
  settings.program = table.text_or("program", settings.program);
  settings.port = static_cast<int>(table.integer_or("instrument", settings.port, 1, 40));
  settings.floor_cd_m2 = table.number_or("floor_cd_m2", settings.floor_cd_m2, 0, 1000);
  return {"", "spotread instrument " + std::to_string(settings.port), "",
          [settings](RigContext&) -> std::unique_ptr<Spectroradiometer> {
            return std::make_unique<Spotread>(settings);
          }};
}

}  // namespace

void add_meter_drivers(DriverCatalogue& catalogue) {
  catalogue.add<Spectroradiometer>("jeti", read_jeti);
  catalogue.add<Spectroradiometer>("spotread", read_spotread);
}

}  // namespace wheatstone
