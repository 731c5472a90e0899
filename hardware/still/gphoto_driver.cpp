#include "hardware/still/gphoto_driver.h"

#include "hardware/still/gphoto_camera.h"

namespace wheatstone {

void add_gphoto_driver(DriverCatalogue& catalogue) {
  catalogue.add<StillCamera>("gphoto2", [](const TomlTable& table) -> DevicePlan<StillCamera> {
    GphotoCameraSettings settings;
    settings.model = table.text_or("model", "");
    settings.serial = table.text_or("serial", "");
    if (settings.model.empty() && settings.serial.empty())
      table.fail("serial", "is missing, and so is \"model\"", "give one of them");
    settings.power_cycle = table.text_or("power_cycle", "");
    settings.power_cycle_limit = Duration::of(
        table.number_or("power_cycle_limit_s", settings.power_cycle_limit.value(), 0.1, 600));
    settings.delivery =
        Duration::of(table.number_or("delivery_s", settings.delivery.value(), 0.1, 120));
    return {"", "usb " + (settings.serial.empty() ? settings.model : settings.serial), "",
            [settings](RigContext& context) -> std::unique_ptr<StillCamera> {
              return std::make_unique<GphotoCamera>(settings, context.deadline);
            }};
  });
}

}  // namespace wheatstone
