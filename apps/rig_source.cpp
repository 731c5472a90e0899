#include "apps/rig_source.h"

#ifdef WHEATSTONE_HAS_HIDAPI
#include "hardware/hid/hid_drivers.h"
#endif
#include "hardware/still/replay_camera.h"
#ifdef WHEATSTONE_HAS_GPHOTO2
#include "hardware/still/gphoto_driver.h"
#include <algorithm>

#include "hardware/network/e131_driver.h"
#ifdef WHEATSTONE_HAS_LIBUSB
#include "hardware/usb/fadecandy.h"
#include "hardware/usb/fadecandy_driver.h"
#endif
#ifdef WHEATSTONE_HAS_V4L2
#include "hardware/video/v4l2_driver.h"
#endif

namespace wheatstone::apps {
namespace {

constexpr Duration kOpenLimit = Duration::of(10);

template <class D>
void keep_if(bool described, Fitted<D>& device, const char* what) {
  if (!described) device = Fitted<D>(what);
}

}  // namespace

DriverCatalogue all_drivers() {
  DriverCatalogue catalogue;
  add_simulated_drivers(catalogue);
  add_serial_drivers(catalogue);
  add_stream_drivers(catalogue);
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
  return catalogue;
}

std::vector<std::string> other_usb_devices([[maybe_unused]] const RigDescription& rig) {
  std::vector<std::string> out;
#ifdef WHEATSTONE_HAS_LIBUSB
  const auto lines = rig.devices();
  try {
    for (const UsbFound& f : list_fadecandies()) {
      const bool ours = std::any_of(lines.begin(), lines.end(), [&](const auto& line) {
        return line.driver == "fadecandy" &&
               (line.address == kOnlyFadecandy || line.address == "usb " + f.serial);
      });
      if (!ours)
        out.push_back("Fadecandy, usb_serial \"" + f.serial + "\"" +
                      (f.trouble.empty() ? "" : " (" + f.trouble + ")"));
    }
  } catch (const DeviceError&) {  // a machine without USB
  }
#endif
  return out;
}

RigSource::RigSource(const SimulatedRigOptions& options)
    : simulation_(options), twin_(std::make_unique<SimulatedRig>(options)) {}

RigSource::RigSource(const RigDescription& description, const std::filesystem::path& transcript)
    : name_(description.name), watchdog_(description.watchdog), description_(description) {
  if (description.simulated()) {
    const auto& s = description.simulation;
    simulation_ = {s.scene, s.scale, s.seed};
    twin_ = std::make_unique<SimulatedRig>(simulation_);
  } else {
    simulation_.scene.clear();
    simulation_.scale = 1;
    simulation_.seed = 0;
    open_ = std::make_unique<OpenRig>(
        description, clock_,
        RigContext{clock_.in(kOpenLimit),
                   transcript.empty() ? nullptr : std::make_shared<Transcript>(transcript),
                   {}});
  }
}

Rig RigSource::rig() {
  if (open_) return open_->rig();
  Rig rig = twin_->rig();
  if (description_.file.empty()) return rig;
  rig.luminance_limit = description_.luminance_limit;
  keep_if(description_.stage.has_value(), rig.stage, "camera rail");
  keep_if(description_.platform.has_value(), rig.platform, "turning platform");
  keep_if(description_.markers.has_value(), rig.markers, "marker lights");
  keep_if(description_.leds.has_value(), rig.leds, "LED array");
  keep_if(description_.camera.has_value(), rig.camera, "still camera");
  return rig;
}

}  // namespace wheatstone::apps
