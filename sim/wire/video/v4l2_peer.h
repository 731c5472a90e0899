#pragma once
// An emulated V4L2 camera that any program finds in /dev and /sys, under umockdev-wrapper.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "sim/wire/mock/mock_bed.h"
#include "sim/wire/video/video_firmware.h"

namespace wheatstone {

struct V4l2PeerOptions {
  std::string node = "video0";
  std::string usb_serial = "SIM-VIDEO";
  std::string name = "Alignment camera";
  bool waits = false;  // for clients that open the node without O_NONBLOCK
};

/// A firmware behind a node. Time is the machine's. Everything here may be called from any thread.
class V4l2Peer {
 public:
  V4l2Peer(MockBed&, VideoFirmware&, V4l2PeerOptions = {});
  ~V4l2Peer();
  V4l2Peer(const V4l2Peer&) = delete;
  V4l2Peer& operator=(const V4l2Peer&) = delete;

  std::filesystem::path node() const;
  std::filesystem::path by_id() const;

  /// Looks at or changes the firmware between two of its answers.
  void with_firmware(const std::function<void()>&);
  void unplug();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheatstone
