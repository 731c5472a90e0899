#pragma once
// Everything that is a still camera, for tests that do not know which.

#include <dlfcn.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>

#include "core/files.h"
#include "hardware/still/gphoto_camera.h"
#include "hardware/still/replay_camera.h"
#include "sim/camera.h"
#include "sim/wire/still/dng.h"
#include "sim/wire/still/usb/still_usb.h"
#include "sim/wire/usb/usb_bus.h"
#include "sim/world.h"
#include "tests/contract/mock_resources.h"
#include "tests/temporary_folder.h"

namespace wheatstone {

class StillBackend {
 public:
  virtual ~StillBackend() = default;
  virtual StillCamera& camera() = 0;
  virtual Clock& clock() = 0;
  virtual World& world() = 0;
  virtual void unplug() = 0;
  /// What it takes is what the box looks like now.
  virtual bool sees() const { return true; }
};

/// In this order every backend takes them; a replay knows no others.
inline constexpr std::array kSeriesS = {1 / 250.0, 1 / 60.0, 1 / 15.0};

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

/// A folder of what the twin took: the series twice.
class ReplayStillBackend final : public StillBackend {
 public:
  ReplayStillBackend() {
    SimulatedCamera twin(world_, true);
    world_.light.led_drive = 1;
    for (std::size_t i = 0; i < 2 * kSeriesS.size(); ++i) {
      const Duration exposure = Duration::of(kSeriesS[i % kSeriesS.size()]);
      DngPicture picture;
      picture.mosaic = twin.expose(exposure, world_.clock.in(Duration::of(5))).mosaic;
      picture.black_dn = world_.camera_profile.black_dn;
      picture.white_dn = world_.camera_profile.white_dn;
      picture.exposure_denominator = static_cast<std::uint32_t>(std::lround(1 / exposure.value()));
      picture.make = "Sony";
      picture.model = "ILCE-7RM3";
      picture.serial = world_.camera_profile.serial;
      write_bytes_atomically(folder() / ("DSC0" + std::to_string(i) + ".dng"), dng_file(picture));
    }
  }
  StillCamera& camera() override {
    if (!camera_) camera_.emplace(folder());
    return *camera_;
  }
  Clock& clock() override { return clock_; }
  World& world() override { return world_; }
  void unplug() override { std::filesystem::remove_all(folder()); }
  bool sees() const override { return false; }
  std::filesystem::path folder() const { return temporary_.path / "pictures"; }

 private:
  SteadyClock clock_;
  World world_{"card", 0.02, 7};
  TemporaryFolder temporary_;
  bool made_ = std::filesystem::create_directory(folder());
  std::optional<ReplayCamera> camera_;
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
  settings.settle = Duration::of(0.1);
  settings.usb_patience = Duration::of(0.8);
  return settings;
}

class GphotoBackend final : public StillBackend {
 public:
  GphotoBackend() : GphotoBackend(std::make_shared<World>("card", 0.02, 7)) {}
  /// In a world that outlives it.
  explicit GphotoBackend(World& world, PtpCameraOptions options = {},
                         std::uint16_t product = StillUsbFirmware::kPcRemote,
                         const std::string& port = "1")
      : GphotoBackend(std::shared_ptr<World>(&world, [](World*) {}), std::move(options), product,
                      port) {}
  explicit GphotoBackend(std::shared_ptr<World> world, PtpCameraOptions options = {},
                         std::uint16_t product = StillUsbFirmware::kPcRemote,
                         const std::string& port = "1")
      : world_(std::move(world)),
        firmware_(*world_, std::move(options)),
        usb_(firmware_, product),
        peer_(still_bed(), usb_, port) {}
  StillCamera& camera() override {
    if (!camera_) open(quick_settings());
    return *camera_;
  }
  void open(const GphotoCameraSettings& settings, Duration limit = Duration::of(5)) {
    camera_ = std::make_unique<GphotoCamera>(settings, clock_.in(limit));
  }
  void close() { camera_.reset(); }
  Clock& clock() override { return clock_; }
  World& world() override { return *world_; }
  void unplug() override { peer_.unplug(); }
  PtpCameraFirmware& firmware() { return firmware_; }
  StillUsbFirmware& usb() { return usb_; }
  UsbDevicePeer& peer() { return peer_; }

 private:
  SteadyClock clock_;
  std::shared_ptr<World> world_;
  PtpCameraFirmware firmware_;
  StillUsbFirmware usb_;
  UsbDevicePeer peer_;
  std::unique_ptr<GphotoCamera> camera_;
};

inline std::ptrdiff_t entries(const char* folder) {
  return std::distance(std::filesystem::directory_iterator(folder), {});
}

#ifdef WHEATSTONE_GPHOTO2_DRIVERS
/// libgphoto2 loads all its drivers and ports before it looks for a camera: here only the two that
/// our body needs. The tests with other programs leave it all of them.
class FewDrivers {
 public:
  FewDrivers() {
    std::filesystem::permissions(folder_.path, std::filesystem::perms(0755));  // also for nobody
    offer("CAMLIBS", WHEATSTONE_GPHOTO2_DRIVERS, "ptp2.so");
    offer("IOLIBS", WHEATSTONE_GPHOTO2_PORTS, "usb1.so");
  }

 private:
  void offer(const std::string& variable, const std::filesystem::path& all, const char* file) {
    const std::filesystem::path few = folder_.path / variable;
    std::filesystem::create_directory(few);
    std::filesystem::create_symlink(all / file, few / file);
    ::setenv(variable.c_str(), few.c_str(), 1);
#ifdef __SANITIZE_ADDRESS__
    // They leak (libgphoto2 2.5.30), and what is unloaded at the end cannot be pardoned by name.
    ::dlopen((few / file).c_str(), RTLD_LAZY | RTLD_NODELETE);
#endif
  }
  TemporaryFolder folder_;
};

/// Loads libgphoto2's drivers, starts the threads of libraries and of the emulation, and waits till
/// it has let go of its client.
inline void warm_up_still() {
  static const FewDrivers few;
  GphotoBackend().camera().expose(Duration::of(kSeriesS[0]), SteadyClock().in(Duration::of(10)));
  const SteadyClock clock;
  for (std::ptrdiff_t before = -1, now = entries("/proc/self/fd"); now != before;) {
    before = now;
    SteadyClock().wait_until(clock.now_ns() + 60'000'000);
    now = entries("/proc/self/fd");
  }
}

#endif

/// ResourceWatch, once the emulation has noticed that its client is gone, and the thread that was
/// left with a call has ended.
class StillResources {
 public:
  ~StillResources() {
    const SteadyClock clock;
    const Nanoseconds end = clock.in(Duration::of(3)).at_ns;
    while ((entries("/proc/self/fd") > handles_ + pardoned_ ||
            entries("/proc/self/task") > threads_) &&
           clock.now_ns() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  /// libgphoto2 2.5 does not close the node of a body that was unplugged while open, nor of one
  /// that another program has; umockdev has two sockets to each.
  void pardon_libgphoto2() {
    pardoned_ += 3;
    watch_.pardon_handles(3);
  }

 private:
  std::ptrdiff_t pardoned_ = 0;
  // Each opening loads all drivers of libgphoto2; worlds and pictures take their time too.
  ResourceWatch watch_{2.0};
  std::ptrdiff_t handles_ = entries("/proc/self/fd"), threads_ = entries("/proc/self/task");
};

}  // namespace wheatstone
