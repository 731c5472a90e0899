#pragma once
// A V4L2 camera without the kernel: its answers to ioctls, in time that is handed in.

#include <linux/videodev2.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/clock.h"
#include "sim/video_camera.h"

namespace wheatstone {

struct VideoFirmwareOptions {
  std::string card = "Alignment camera";
  std::uint32_t device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING | V4L2_CAP_READWRITE;
  std::uint32_t padding_bytes = 16;  // at the end of each line
  std::uint32_t stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  std::uint32_t first_sequence = 0;
  bool noise = true;
};

/// Answers as a UVC camera's driver would, with the sensor of SimulatedVideoCamera: its formats,
/// Y10, packed Y10P, YUYV, MJPG without Huffman tables, and RGGB, RG10 and pRAA as if each colour
/// saw luminance. Pictures come on time and are lost while no buffer is free. Not for two threads
/// at once.
class VideoFirmware {
 public:
  explicit VideoFirmware(World&, const VideoFirmwareOptions& = {});

  /// 0 or errno. `argument` is the structure of the request and is changed in place.
  int ioctl(unsigned long request, void* argument, Nanoseconds now);
  /// As read(2) into `out`: a number of bytes, or -errno; starts the stream. EAGAIN: none yet.
  int read(std::span<std::uint8_t> out, Nanoseconds now);
  /// When the next picture is done. Pre: streaming().
  Nanoseconds next_picture_ns() const { return start_ns_ + period_ns() * (frame_ + 1); }
  bool streaming() const { return streaming_; }

  /// What the wire has to know: the buffers asked for, and where each lies now.
  std::uint32_t buffer_count() const { return static_cast<std::uint32_t>(buffers_.size()); }
  std::uint32_t buffer_bytes() const { return format_.sizeimage; }
  std::uint32_t buffer_memory() const { return memory_; }
  void place_buffer(std::uint32_t index, std::span<std::uint8_t> bytes) {
    buffers_[index].bytes = bytes;
  }
  std::int32_t control(std::uint32_t id) const { return controls_.at(id).value; }

  // Faults. Both may be empty.
  /// Sees every answer before it goes out; returns the errno to give instead.
  std::function<int(unsigned long request, void* argument, int result)> spoil;
  /// Changes the bytes of every picture.
  std::function<void(std::vector<std::uint8_t>&)> spoil_picture;
  bool silent = false;  // no pictures come

 private:
  struct Buffer {
    std::span<std::uint8_t> bytes;
    v4l2_buffer about{};
    bool queued = false;
  };
  struct Control {
    const char* name;
    std::int32_t minimum, maximum, value;
    std::uint32_t held_by = 0;  // the automatic that must be off
    std::int32_t off = 0;
  };

  int answer(unsigned long request, void* argument, Nanoseconds now);
  int capability(v4l2_capability&) const;
  int enumerate_format(v4l2_fmtdesc&) const;
  int enumerate_size(v4l2_frmsizeenum&) const;
  int enumerate_interval(v4l2_frmivalenum&) const;
  int try_format(v4l2_format&) const;
  int set_rate(v4l2_streamparm&);
  int query_control(v4l2_queryctrl&) const;
  int set_control(const v4l2_control&);
  int request_buffers(v4l2_requestbuffers&);
  int query_buffer(v4l2_buffer&) const;
  int queue(v4l2_buffer&);
  int dequeue(v4l2_buffer&, Nanoseconds now);
  void stream(bool on, Nanoseconds now);
  void advance(Nanoseconds now);
  std::vector<std::uint8_t> picture(std::uint32_t frame);
  Nanoseconds period_ns() const;
  Duration exposure() const;

  World& world_;
  VideoFirmwareOptions options_;
  VideoSensor sensor_;
  v4l2_pix_format format_{};
  double frames_per_s_ = 30;
  std::map<std::uint32_t, Control> controls_;
  std::uint32_t memory_ = 0;
  std::vector<Buffer> buffers_;
  std::deque<std::uint32_t> waiting_, done_;  // indices
  bool streaming_ = false;
  Nanoseconds start_ns_ = 0;
  std::int64_t frame_ = 0;
  // Without noise all pictures under the same light and settings are equal: the last one is kept.
  std::vector<std::uint8_t> still_;
  BoxLight still_light_;
};

}  // namespace wheatstone
