#include "hardware/outputs/xrandr_driver.h"

#include "hardware/outputs/xrandr_outputs.h"

namespace wheatstone {

void add_xrandr_driver(DriverCatalogue& catalogue) {
  catalogue.add<DisplayOutputs>("xrandr", [](const TomlTable& table) -> DevicePlan<DisplayOutputs> {
    XrandrSettings settings;
    settings.display = table.text_or("display", "");
    return {"", settings.display.empty() ? "X server" : "X server " + settings.display, "",
            [settings](RigContext& context) -> std::unique_ptr<DisplayOutputs> {
              return std::make_unique<XrandrOutputs>(settings, context.deadline);
            }};
  });
}

}  // namespace wheatstone
