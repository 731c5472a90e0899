#include "hardware/video/v4l2_driver.h"

#include "hardware/video/v4l2_camera.h"

namespace wheatstone {
namespace {

V4l2Transfer transfer(const TomlTable& table) {
  const std::string name = table.text_or("transfer", "mmap");
  if (name == "mmap") return V4l2Transfer::kMmap;
  if (name == "userptr") return V4l2Transfer::kUserPointer;
  if (name == "read") return V4l2Transfer::kRead;
  table.fail("transfer", R"(must be "mmap", "userptr" or "read")");
}

}  // namespace

void add_v4l2_driver(DriverCatalogue& catalogue) {
  catalogue.add<VideoCamera>("v4l2", [](const TomlTable& table) -> DevicePlan<VideoCamera> {
    V4l2CameraSettings settings;
    settings.usb_serial = table.text_or("usb_serial", "");
    if (settings.usb_serial.empty()) settings.node = table.text("node");
    settings.transfer = transfer(table);
    settings.buffers = static_cast<int>(table.integer_or("buffers", settings.buffers, 2, 32));
    return {"", settings.usb_serial.empty() ? settings.node.string() : "usb " + settings.usb_serial,
            "", [settings](RigContext&) -> std::unique_ptr<VideoCamera> {
              return std::make_unique<V4l2Camera>(settings);
            }};
  });
}

}  // namespace wheatstone
