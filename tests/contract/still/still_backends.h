#pragma once
// Everything that is a still camera, for tests that do not know which.

#include <filesystem>
#include <memory>
#include <thread>

#include "hardware/still/gphoto_camera.h"
#include "sim/camera.h"
#include "sim/wire/still/usb/still_usb.h"
#include "sim/wire/usb/usb_bus.h"
#include "sim/world.h"
#include "tests/contract/resources.h"

namespace wheatstone {

class StillBackend {
 public:
  virtual ~StillBackend() = default;
  virtual StillCamera& camera() = 0;
  virtual Clock& clock() = 0;
  virtual World& world() = 0;
  virtual void unplug() = 0;
};

class TwinStillBackend final : public StillBackend {
 public:
  StillCamera& camera() override { return camera_; }
  Clock& clock() override { return world_.clock; }
  World& world() override { return world_; }
  void unplug() override { world_.faults.arm("camera", DeviceError::Kind::kDisconnected); }

 private:
  World world_{"card", 0.02, 7};
  SimulatedCamera camera_{world_, true};
};

/// The emulated machine; it has threads of its own, which must not count as left behind.
inline MockBed& still_bed() {
  static MockBed bed;
  return bed;
}

inline GphotoCameraSettings quick_settings() {
  GphotoCameraSettings settings;
  settings.model = "Alpha-A7r III";
  settings.delivery = Duration::of(0.3);
  settings.usb_patience = Duration::of(0.3);
  return settings;
}

class GphotoBackend final : public StillBackend {
 public:
  explicit GphotoBackend(PtpCameraOptions options = {},
                         std::uint16_t product = StillUsbFirmware::kPcRemote)
      : firmware_(world_, options), usb_(firmware_, product), peer_(still_bed(), usb_) {}
  StillCamera& camera() override {
    if (!camera_) open(quick_settings());
    return *camera_;
  }
  void open(const GphotoCameraSettings& settings, Duration limit = Duration::of(5)) {
    camera_ = std::make_unique<GphotoCamera>(settings, clock_.in(limit));
  }
  void close() { camera_.reset(); }
  Clock& clock() override { return clock_; }
  World& world() override { return world_; }
  void unplug() override { peer_.unplug(); }
  PtpCameraFirmware& firmware() { return firmware_; }
  StillUsbFirmware& usb() { return usb_; }
  UsbDevicePeer& peer() { return peer_; }

 private:
  SteadyClock clock_;
  World world_{"card", 0.02, 7};
  PtpCameraFirmware firmware_;
  StillUsbFirmware usb_;
  UsbDevicePeer peer_;
  std::unique_ptr<GphotoCamera> camera_;
};

}  // namespace wheatstone
