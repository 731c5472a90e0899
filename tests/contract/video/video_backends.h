#pragma once
// Everything that is a video camera, for tests that do not know which: the twin, and the V4L2
// driver on an emulated camera, with each way of transfer.

#include <memory>

#include "hardware/video/v4l2_camera.h"
#include "sim/video_camera.h"
#include "sim/wire/video/v4l2_peer.h"
#include "sim/world.h"
#include "tests/contract/mock_resources.h"
#include "tests/contract/warm_up.h"

namespace wheatstone {

class VideoBackend {
 public:
  virtual ~VideoBackend() = default;
  virtual VideoCamera& camera() = 0;
  virtual Clock& clock() = 0;
  virtual World& world() = 0;
  virtual void unplug() = 0;
  /// Frames that nobody fetches are lost, and it can tell.
  virtual bool counts_frames() const { return true; }
};

class TwinVideoBackend final : public VideoBackend {
 public:
  VideoCamera& camera() override { return camera_; }
  Clock& clock() override { return world_.clock; }
  World& world() override { return world_; }
  void unplug() override { world_.faults.arm("video", DeviceError::Kind::kDisconnected); }

 private:
  World world_{"card", 0.02, 7};
  SimulatedVideoCamera camera_{world_};
};

class V4l2Backend : public VideoBackend {
 public:
  explicit V4l2Backend(MockBed& bed, V4l2Transfer transfer = V4l2Transfer::kMmap,
                       const VideoFirmwareOptions& options = {})
      : transfer_(transfer), firmware_(world_, options), peer_(bed, firmware_) {}
  VideoCamera& camera() override {
    if (!camera_) {
      V4l2CameraSettings settings;
      settings.usb_serial = "SIM-VIDEO";
      settings.transfer = transfer_;
      camera_ = std::make_unique<V4l2Camera>(settings);
    }
    return *camera_;
  }
  Clock& clock() override { return clock_; }
  World& world() override { return world_; }
  void unplug() override { peer_.unplug(); }
  bool counts_frames() const override { return transfer_ != V4l2Transfer::kRead; }
  V4l2Peer& peer() { return peer_; }
  VideoFirmware& firmware() { return firmware_; }

 private:
  SteadyClock clock_;
  V4l2Transfer transfer_;
  World world_{"card", 0.02, 7};
  VideoFirmware firmware_;
  V4l2Peer peer_;
  std::unique_ptr<V4l2Camera> camera_;
};

/// The emulated machine; it has threads of its own, which must not count as left behind.
inline MockBed& video_bed() {
  static MockBed bed;
  return bed;
}

/// Starts the threads of libraries and of the emulation, and waits till it has let go of its
/// client.
inline void warm_up_video() {
  warm_up();
  V4l2Backend(video_bed()).camera();
  settle_handles();
}

/// Worlds and pictures take their time.
struct VideoResources : MockResources {
  VideoResources() : MockResources(1.0) {}
};

}  // namespace wheatstone
