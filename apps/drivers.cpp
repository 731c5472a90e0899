#include "apps/drivers.h"

#include <algorithm>
#include <filesystem>

#include "hardware/network/e131_driver.h"
#include "hardware/still/replay_camera.h"
#include "sim/display_outputs.h"
#ifdef WHEATSTONE_HAS_HIDAPI
#include "hardware/hid/hid_drivers.h"
#endif
#ifdef WHEATSTONE_HAS_LIBUSB
#include "hardware/usb/fadecandy.h"
#include "hardware/usb/fadecandy_driver.h"
#endif
#ifdef WHEATSTONE_HAS_GPHOTO2
#include "hardware/still/gphoto_camera.h"
#include "hardware/still/gphoto_driver.h"
#endif
#ifdef WHEATSTONE_HAS_V4L2
#include "hardware/video/v4l2_driver.h"
#endif
#ifdef WHEATSTONE_HAS_XRANDR
#include "hardware/outputs/xrandr_driver.h"
#endif

namespace wheatstone::apps {
namespace {

void add_serial_lines(const RigDescription& rig, std::vector<OtherDevice>& out) {
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/dev/serial/by-id", none)) {
    bool ours = false;
    for (const auto& device : rig.devices())
      ours = ours || std::filesystem::equivalent(device.address, entry.path(), none);
    if (!ours) out.push_back({"serial line", entry.path().string(), ""});
  }
}

[[maybe_unused]] bool names(const RigDescription& rig, const std::string& address) {
  const auto devices = rig.devices();
  return std::any_of(devices.begin(), devices.end(),
                     [&](const auto& device) { return device.address == address; });
}

#ifdef WHEATSTONE_HAS_HIDAPI
void add_lights(const RigDescription& rig, std::vector<OtherDevice>& out) {
  for (const HidLightFound& light : list_hid_lights())
    if (!names(rig, light.address))
      out.push_back({"marker light",
                     (light.address.empty() ? "one" : light.address) + " on " + light.node,
                     light.problem});
}
#endif

#ifdef WHEATSTONE_HAS_LIBUSB
void add_fadecandies(const RigDescription& rig, std::vector<OtherDevice>& out) {
  try {
    for (const UsbFound& f : list_fadecandies())
      if (!names(rig, kOnlyFadecandy) && !names(rig, "usb " + f.serial))
        out.push_back({"LED array", "Fadecandy, usb_serial \"" + f.serial + "\"", f.trouble});
  } catch (const DeviceError&) {  // a machine without USB
  }
}
#endif

#ifdef WHEATSTONE_HAS_GPHOTO2
void add_still_cameras(const std::vector<DeviceDiagnosis>& found, std::vector<OtherDevice>& out) {
  for (const StillCameraFound& camera : list_still_cameras()) {
    const bool ours = std::any_of(found.begin(), found.end(), [&](const DeviceDiagnosis& d) {
      return d.status == "ok" && d.driver == "gphoto2" && d.identity.serial == camera.serial;
    });
    if (ours) continue;
    std::string address = camera.model + " at " + camera.address;
    if (!camera.serial.empty()) address += ", serial " + camera.serial;
    out.push_back({"still camera", address, camera.trouble});
  }
}
#endif

}  // namespace

DriverCatalogue all_drivers() {
  DriverCatalogue catalogue;
  add_simulated_drivers(catalogue);
  add_simulated_outputs_driver(catalogue);
  add_serial_drivers(catalogue);
  add_stream_drivers(catalogue);
  add_meter_drivers(catalogue);
#ifdef WHEATSTONE_HAS_HIDAPI
  add_hid_drivers(catalogue);
#else
  catalogue.add_missing("hid-relay", "libhidapi-dev");
  catalogue.add_missing("blink1", "libhidapi-dev");
#endif
  add_replay_driver(catalogue);
#ifdef WHEATSTONE_HAS_GPHOTO2
  add_gphoto_driver(catalogue);
#else
  catalogue.add_missing("gphoto2", "libgphoto2-dev");
#endif
  add_e131_driver(catalogue);
#ifdef WHEATSTONE_HAS_LIBUSB
  add_fadecandy_driver(catalogue);
#else
  catalogue.add_missing("fadecandy", "libusb-1.0-0-dev");
#endif
#ifdef WHEATSTONE_HAS_V4L2
  add_v4l2_driver(catalogue);
#else
  catalogue.add_missing("v4l2", "linux-libc-dev");
#endif
#ifdef WHEATSTONE_HAS_XRANDR
  add_xrandr_driver(catalogue);
#else
  catalogue.add_missing("xrandr", "libxcb-randr0-dev");
#endif
  return catalogue;
}

std::vector<OtherDevice> other_devices(const RigDescription& rig,
                                       [[maybe_unused]] const std::vector<DeviceDiagnosis>& found) {
  std::vector<OtherDevice> out;
  add_serial_lines(rig, out);
#ifdef WHEATSTONE_HAS_HIDAPI
  add_lights(rig, out);
#endif
#ifdef WHEATSTONE_HAS_LIBUSB
  add_fadecandies(rig, out);
#endif
#ifdef WHEATSTONE_HAS_GPHOTO2
  add_still_cameras(found, out);
#endif
  return out;
}

}  // namespace wheatstone::apps
