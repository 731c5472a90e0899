#include "hardware/network/udp_head_tracker.h"
#include "hardware/rig_file/driver_catalogue.h"
#include "hardware/serial/photodiode.h"
#include "hardware/serial/serial_head_tracker.h"

namespace wheatstone {
namespace {

DevicePlan<HeadTracker> read_serial_head_tracker(const TomlTable& table) {
  SerialHeadTrackerSettings settings;
  settings.line = table.text("port");
  settings.baud = static_cast<int>(table.integer_or("baud", settings.baud, 9600, 921600));
  settings.serial = table.text_or("serial", "");
  return {"", settings.line.string(), "",
          [settings](RigContext& context) -> std::unique_ptr<HeadTracker> {
            return std::make_unique<SerialHeadTracker>(settings, context.transcript);
          }};
}

DevicePlan<HeadTracker> read_udp_head_tracker(const TomlTable& table) {
  UdpHeadTrackerSettings settings;
  settings.address = table.text_or("listen", settings.address);
  settings.port = static_cast<int>(table.integer("udp_port", 1, 65535));
  settings.from = table.text_or("from", "");
  settings.serial = table.text_or("serial", "");
  return {"", "udp " + std::to_string(settings.port), "",
          [settings](RigContext& context) -> std::unique_ptr<HeadTracker> {
            return std::make_unique<UdpHeadTracker>(settings, context.transcript);
          }};
}

DevicePlan<LightSensor> read_photodiode(const TomlTable& table) {
  SerialPhotodiodeSettings settings;
  settings.line = table.text("port");
  settings.baud = static_cast<int>(table.integer_or("baud", settings.baud, 9600, 921600));
  settings.serial = table.text_or("serial", "");
  return {"", settings.line.string(), "",
          [settings](RigContext& context) -> std::unique_ptr<LightSensor> {
            return std::make_unique<SerialPhotodiode>(settings, context.transcript);
          }};
}

}  // namespace

void add_stream_drivers(DriverCatalogue& catalogue) {
  catalogue.add<HeadTracker>("serial-head-tracker", read_serial_head_tracker);
  catalogue.add<HeadTracker>("udp-head-tracker", read_udp_head_tracker);
  catalogue.add<LightSensor>("photodiode", read_photodiode);
}

}  // namespace wheatstone
