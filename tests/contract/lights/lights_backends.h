#pragma once
// Everything that is marker lights, for tests that do not know which: the twin, and the drivers of
// relay boards and blink(1) on emulated ones.

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hardware/hid/blink1.h"
#include "hardware/hid/relay_board.h"
#include "sim/lights.h"
#include "sim/wire/hid/blink1_firmware.h"
#include "sim/wire/hid/hid_peer.h"
#include "sim/wire/hid/relay_firmware.h"
#include "sim/world.h"
#include "tests/contract/mock_resources.h"
#include "tests/contract/warm_up.h"

namespace wheatstone {

/// Worlds take their time to make: each test has one that another one has done with.
class UsedWorld {
 public:
  UsedWorld() {
    if (idle().empty()) idle().push_back(std::make_unique<World>("card", 0.02, 7));
    world_ = std::move(idle().back());
    idle().pop_back();
  }
  ~UsedWorld() {
    world_->light.marker_mask = 0;
    world_->faults.reconnect("markers");
    idle().push_back(std::move(world_));
  }
  UsedWorld(const UsedWorld&) = delete;
  UsedWorld& operator=(const UsedWorld&) = delete;
  World& operator*() { return *world_; }

 private:
  static std::vector<std::unique_ptr<World>>& idle() {
    static std::vector<std::unique_ptr<World>> worlds;
    return worlds;
  }
  std::unique_ptr<World> world_;
};

class LightsBackend {
 public:
  virtual ~LightsBackend() = default;
  virtual MarkerLights& lights() = 0;
  virtual void close() = 0;  // the object goes
  virtual Clock& clock() = 0;
  virtual void unplug() = 0;
  MarkerLights::Mask truth() {
    const std::lock_guard lock(world().mutex);
    return world().light.marker_mask;
  }
  World& world() { return *world_; }

 private:
  UsedWorld world_;
};

class TwinLightsBackend final : public LightsBackend {
 public:
  MarkerLights& lights() override {
    if (!lights_) lights_.emplace(world());
    return *lights_;
  }
  void close() override { lights_.reset(); }
  Clock& clock() override { return world().clock; }
  void unplug() override { world().faults.arm("markers", DeviceError::Kind::kDisconnected); }

 private:
  std::optional<SimulatedMarkers> lights_;
};

/// A driver on an emulated device.
class HidLightsBackend : public LightsBackend {
 public:
  MarkerLights& lights() override {
    if (!lights_) lights_ = open(clock_.in(Duration::of(2)));
    return *lights_;
  }
  virtual std::unique_ptr<MarkerLights> open(const Deadline&) = 0;
  void close() override { lights_.reset(); }
  Clock& clock() override { return clock_; }
  void unplug() override { peer().unplug(); }
  virtual HidPeer& peer() = 0;
  virtual HidFirmware& firmware() = 0;

 private:
  SteadyClock clock_;
  std::unique_ptr<MarkerLights> lights_;
};

class RelayBackend final : public HidLightsBackend {
 public:
  explicit RelayBackend(MockBed& bed, int number = 0, const std::string& name = "BITFT",
                        int channels = 4)
      : firmware_(world(), name, channels), peer_(bed, firmware_, number) {}
  ~RelayBackend() override { close(); }
  std::unique_ptr<MarkerLights> open(const Deadline& deadline) override {
    return std::make_unique<RelayBoard>(settings(), deadline);
  }
  static RelayBoardSettings settings() { return {"BITFT", Duration::of(0.05), nullptr}; }
  HidPeer& peer() override { return peer_; }
  RelayFirmware& firmware() override { return firmware_; }

 private:
  RelayFirmware firmware_;
  HidPeer peer_;
};

class Blink1Backend final : public HidLightsBackend {
 public:
  explicit Blink1Backend(MockBed& bed, int number = 0, const std::string& serial = "2A00CAFE")
      : firmware_(world(), serial), peer_(bed, firmware_, number) {}
  ~Blink1Backend() override { close(); }
  std::unique_ptr<MarkerLights> open(const Deadline& deadline) override {
    return std::make_unique<Blink1>(settings(), deadline);
  }
  static Blink1Settings settings() { return {"2A00CAFE", {255, 120, 0}, nullptr}; }
  HidPeer& peer() override { return peer_; }
  Blink1Firmware& firmware() override { return firmware_; }

 private:
  Blink1Firmware firmware_;
  HidPeer peer_;
};

/// The emulated machine; it has threads of its own, which must not count as left behind.
inline MockBed& hid_bed() {
  static MockBed bed;
  return bed;
}

/// Starts the threads of libraries and of the emulation.
inline void warm_up_hid() {
  warm_up();
  RelayBackend(hid_bed()).lights();
  settle_handles();
}

}  // namespace wheatstone
