#pragma once
// A whole rig at the other end of emulated wires: GRBL on a pseudo-terminal, a relay board on
// hidraw, Fadecandy and a camera body on USB, all acting on one World.

#include <cmath>
#include <mutex>
#include <optional>
#include <string>

#include "core/dataset.h"
#include "core/files.h"
#include "hardware/led_mapping.h"
#include "sim/scene.h"
#include "sim/wire/grbl_firmware.h"
#include "sim/wire/hid/hid_peer.h"
#include "sim/wire/hid/relay_firmware.h"
#include "sim/wire/led_ceiling.h"
#include "sim/wire/pty_peer.h"
#include "sim/wire/still/usb/still_usb.h"
#include "sim/wire/usb/fadecandy_firmware.h"
#include "sim/wire/usb/usb_bus.h"

namespace wheatstone {

inline constexpr double kWiredScale = 0.02;
inline constexpr std::uint64_t kWiredSeed = 7;

inline MockBed& wired_bed() {
  static MockBed bed;
  return bed;
}

/// Plugged in from construction to destruction; what it sees begins anew with each.
class WiredRig {
 public:
  enum class Device { kRail, kMarkers, kLeds, kCamera };

  explicit WiredRig(const std::filesystem::path& folder)
      : rail_(rail_firmware_, folder / "rail", 40) {
    rail_.with_firmware([&] { rail_firmware_.set(100, kStageStepsPerMm); });
    write_camera_profile(folder / "camera.json", world_.camera_profile);
    std::string markers;
    for (const Eigen::Vector3d& p : marker_positions_rsb_mm())
      markers += (markers.empty() ? "[" : ", [") + std::to_string(p.x()) + ", " +
                 std::to_string(p.y()) + ", " + std::to_string(p.z()) + "]";
    write_text_atomically(folder / "rig.toml",
                          "schema = \"wheatstone-rig/1\"\nname = \"wired\"\n"
                          "[stage]\ndriver = \"grbl\"\nport = \"" +
                              (folder / "rail").string() +
                              "\"\ntravel_mm = 167\n"
                              "[markers]\ndriver = \"hid-relay\"\nboard = \"BITFT\"\nsettle_s = 0\n"
                              "[leds]\ndriver = \"fadecandy\"\ndither = false\n"
                              "[camera]\ndriver = \"gphoto2\"\nserial = \"" +
                              world_.camera_profile.serial +
                              "\"\ndelivery_s = 2\n"
                              "[geometry]\nmarkers_rsb_mm = [" +
                              markers +
                              "]\n"
                              "[calibration]\ncamera = \"camera.json\"\n"
                              "[safety]\nluminance_limit_cd_m2 = 3000\n");
  }

  /// Its cable is pulled when it has taken so many more bytes (rail), transfers (markers, camera)
  /// or packets (LEDs).
  void unplug_after(Device device, int count) {
    switch (device) {
      case Device::kRail:
        return rail_.unplug_after(static_cast<std::size_t>(count));
      case Device::kMarkers:
        return markers_.unplug_after(count);
      case Device::kLeds:
        return leds_.with_firmware([&] { leds_firmware_.unplugs_after = count; });
      case Device::kCamera:
        return camera_.with_firmware([&] {
          camera_usb_.meet = [left = count](std::uint8_t) mutable {
            return left-- == 0 ? std::optional(UsbReply::End::kUnplugged) : std::nullopt;
          };
        });
    }
  }

  BoxLight light() {
    const std::lock_guard lock(world_.mutex);
    return world_.light;
  }
  /// Whether the carriage comes to a stand within a second.
  bool comes_to_rest() {
    SteadyClock clock;
    const Nanoseconds end = clock.in(Duration::of(1)).at_ns;
    for (bool moving = true;;) {
      rail_.with_firmware([&] { moving = rail_firmware_.moving(); });
      if (!moving || clock.now_ns() > end) return !moving;
      clock.wait_until(clock.now_ns() + 1'000'000);
    }
  }

 private:
  GrblFirmware::Machine carriage() {
    return {[this](int axis) {
              const std::lock_guard lock(world_.mutex);
              if (axis == 0) world_.home_carriage();
            },
            [this](int axis, std::int64_t steps) {
              const std::lock_guard lock(world_.mutex);
              if (axis == 0) world_.move_carriage(static_cast<double>(steps) / kStageStepsPerMm);
            }};
  }
  static PtpCameraOptions quick_camera() {
    PtpCameraOptions options;
    options.time_scale = 100;
    return options;
  }

  World world_{"card", kWiredScale, kWiredSeed};
  GrblFirmware rail_firmware_{{}, carriage()};
  PtyPeer rail_;
  RelayFirmware markers_firmware_{world_};
  HidPeer markers_{wired_bed(), markers_firmware_};  // in port 1
  LedCeiling ceiling_{world_, places_on_wire(LedMapping())};
  FadecandyFirmware leds_firmware_{ceiling_};
  UsbDevicePeer leds_{wired_bed(), leds_firmware_, "2"};
  PtpCameraFirmware camera_firmware_{world_, quick_camera()};
  StillUsbFirmware camera_usb_{camera_firmware_};
  UsbDevicePeer camera_{wired_bed(), camera_usb_, "3"};
};

}  // namespace wheatstone
