#pragma once
// Everything that is a head tracker: the twin, and the drivers on emulated trackers.

#include <memory>

#include "hardware/network/udp_head_tracker.h"
#include "hardware/serial/serial_head_tracker.h"
#include "sim/head_tracker.h"
#include "sim/wire/head_tracker_firmware.h"
#include "sim/wire/pty_peer.h"
#include "sim/wire/udp_peer.h"
#include "sim/world.h"

namespace wheatstone {

class HeadTrackerBackend {
 public:
  virtual ~HeadTrackerBackend() = default;
  virtual HeadTracker& tracker() = 0;
  virtual Clock& clock() = 0;
  /// When the observer's own time was 0.
  virtual Nanoseconds epoch_ns() const = 0;
  /// False: it cannot be told from silence.
  virtual bool unplug() = 0;
};

class TwinHeadTrackerBackend final : public HeadTrackerBackend {
 public:
  HeadTracker& tracker() override { return tracker_; }
  Clock& clock() override { return world_.clock; }
  Nanoseconds epoch_ns() const override { return 0; }
  bool unplug() override {
    world_.faults.arm("tracker", DeviceError::Kind::kDisconnected);
    return true;
  }
  World& world() { return world_; }

 private:
  World world_{"card", 0.02, 7};
  SimulatedHeadTracker tracker_{world_};
};

/// With the driver on Peer's other end.
template <class Peer>
class StreamBackend : public HeadTrackerBackend {
 public:
  explicit StreamBackend(std::uint32_t first_number = 0)
      : firmware_(world_, "SIM-TRACKER", first_number) {}
  Clock& clock() override { return clock_; }
  Nanoseconds epoch_ns() const override { return epoch_ns_; }
  virtual Peer& peer() = 0;
  HeadTrackerFirmware& firmware() { return firmware_; }

 protected:
  SteadyClock clock_;
  World world_{"card", 0.02, 7};
  HeadTrackerFirmware firmware_;
  Nanoseconds epoch_ns_ = clock_.now_ns();
};

class SerialHeadTrackerBackend final : public StreamBackend<PtyPeer> {
 public:
  using StreamBackend::StreamBackend;
  HeadTracker& tracker() override {
    if (!tracker_)
      tracker_ = std::make_unique<SerialHeadTracker>(
          SerialHeadTrackerSettings{peer_.path(), 115200, "SIM-TRACKER"});
    return *tracker_;
  }
  bool unplug() override {
    peer_.unplug();
    return true;
  }
  PtyPeer& peer() override { return peer_; }
  void close() { tracker_.reset(); }

 private:
  PtyPeer peer_{firmware_};
  std::unique_ptr<SerialHeadTracker> tracker_;
};

class UdpHeadTrackerBackend final : public StreamBackend<UdpPeer> {
 public:
  explicit UdpHeadTrackerBackend(std::uint32_t first_number = 0, const std::string& from = {})
      : StreamBackend(first_number), tracker_({"127.0.0.1", 0, from, "SIM-TRACKER"}) {}
  HeadTracker& tracker() override { return tracker_; }
  bool unplug() override { return false; }
  UdpPeer& peer() override { return peer_; }
  int port() const { return tracker_.port(); }

 private:
  UdpHeadTracker tracker_;
  UdpPeer peer_{firmware_, tracker_.port()};
};

}  // namespace wheatstone
