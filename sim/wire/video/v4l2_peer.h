#pragma once
// An emulated V4L2 camera that any program finds in /dev and /sys, under umockdev-wrapper.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "sim/wire/video/video_firmware.h"

namespace wheatstone {

/// The machine's devices as the program and its children see them: none but the emulated ones. One
/// at a time in a process.
class VideoBed {
 public:
  /// Throws DeviceError kNotReady unless the program was started by umockdev-wrapper.
  VideoBed();
  ~VideoBed();
  VideoBed(const VideoBed&) = delete;
  VideoBed& operator=(const VideoBed&) = delete;

 private:
  friend class V4l2Peer;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct V4l2PeerOptions {
  std::string node = "video0";
  std::string usb_serial = "SIM-VIDEO";
  std::string name = "Alignment camera";
  bool waits = false;  // for clients that open the node without O_NONBLOCK
};

/// A firmware behind a node. Time is the machine's. Everything here may be called from any thread.
class V4l2Peer {
 public:
  V4l2Peer(VideoBed&, VideoFirmware&, V4l2PeerOptions = {});
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
