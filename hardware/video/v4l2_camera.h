#pragma once
// A video camera on Video for Linux 2.

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "hardware/video/pixel_formats.h"
#include "hardware/video/v4l2_buffers.h"
#include "hardware/video/v4l2_node.h"
#include "hardware/video_camera.h"

namespace wheatstone {

struct V4l2CameraSettings {
  std::string usb_serial;      // found by it, whichever port it is in; or else
  std::filesystem::path node;  // "/dev/v4l/by-id/...-index0", "/dev/v4l/by-path/...", "/dev/video0"
  V4l2Transfer transfer = V4l2Transfer::kMmap;
  int buffers = 4;  // asked for; 2..32
};

/// A camera that is plugged in.
struct VideoCameraFound {
  std::filesystem::path node;
  std::string model, usb_serial;
  std::string trouble;  // why it cannot be opened; empty: it can
};
/// In the order of their nodes; nodes that capture nothing are left out.
std::vector<VideoCameraFound> list_video_cameras();

/// Stamps are the kernel's where it stamps on the monotonic clock, moved to mid-exposure: half an
/// exposure after a stamp of its start, half an exposure before one of its end (a rolling shutter's
/// readout is not known and not taken off). Stamps that go back or lie ahead of the clock are not
/// believed; the time of arrival replaces them. With kRead neither stamps nor sequence numbers come
/// over, so nothing counts as lost.
/// A stream that fails (EIO) is started again, and one frame counts as lost.
class V4l2Camera final : public VideoCamera {
 public:
  /// Throws ArgumentError for settings without an address or with a bad number of buffers;
  /// kNotFound, also if several have this serial or the node does not capture; kPermission; kBusy.
  explicit V4l2Camera(const V4l2CameraSettings&);
  ~V4l2Camera() override;

  DeviceIdentity identity() const override { return identity_; }
  /// Formats that decode() knows. Of sizes and rates in steps, the first and the last.
  std::vector<VideoMode> modes(Deadline) override;
  VideoSettings configure(const VideoMode&, Duration exposure, double gain, Deadline) override;
  void start(Deadline) override;
  VideoFrame next(Deadline) override;
  std::uint64_t dropped() const override { return dropped_; }
  void stop() noexcept override;

 private:
  void identify();
  VideoMode set_format(const VideoMode&, const Deadline&);
  double set_rate(double frames_per_s, const Deadline&);
  void require_started() const;
  bool wait(const Deadline&);
  void nap(const Deadline&);
  void restart(const Deadline&);
  void count_gap(std::uint32_t sequence);
  void stamp(const V4l2Filled&, VideoFrame&);

  V4l2CameraSettings settings_;
  V4l2Node node_;
  DeviceIdentity identity_;
  PixelLayout layout_;
  std::size_t image_bytes_ = 0;
  VideoSettings granted_;
  bool configured_ = false;
  std::unique_ptr<V4l2Buffers> buffers_;  // kept after stop(), which may come from another thread
  std::atomic<bool> started_ = false;
  bool any_frame_ = false;
  std::uint32_t last_sequence_ = 0;
  Nanoseconds last_stamp_ns_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace wheatstone
