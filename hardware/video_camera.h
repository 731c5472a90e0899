#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/units.h"
#include "hardware/device.h"

namespace wheatstone {

struct VideoMode {
  std::string format;  // four characters as V4L2 has them: "GREY", "Y16 ", "YUYV", "MJPG", "RGGB"
  int width_px = 0, height_px = 0;
  double frames_per_s = 0;
  friend bool operator==(const VideoMode&, const VideoMode&) = default;
};

/// What the camera really does; a driver may grant something else than was asked.
struct VideoSettings {
  VideoMode mode;
  Duration exposure;  // 0: the camera does not say
  double gain = 0;    // in the camera's own units
  friend bool operator==(const VideoSettings&, const VideoSettings&) = default;
};

/// Pixels are a copy: CV_8UC1 for GREY and 8-bit Bayer, CV_16UC1 for Y10, Y12, Y16 and deeper Bayer
/// (codes in the low bits as the camera gives them), CV_8UC3 encoded R, G, B for YUYV and MJPG,
/// which are for looking, not for measuring.
struct VideoFrame {
  cv::Mat pixels;
  std::string format;  // of the mode
  std::uint32_t sequence = 0;
  Nanoseconds mid_exposure_ns = 0;  // on the machine's monotonic clock
  bool time_is_the_cameras = true;  // false: taken when the frame arrived
};

/// For alignment and tracking.
class VideoCamera : public Device {
 public:
  virtual std::vector<VideoMode> modes(Deadline) = 0;
  /// Manual exposure, all automatic control off. Throws kOutOfRange for a mode that is not offered,
  /// kNotReady while started.
  virtual VideoSettings configure(const VideoMode&, Duration exposure, double gain, Deadline) = 0;
  virtual void start(Deadline) = 0;
  /// The next frame that is whole; damaged ones count as dropped. Throws kNotReady unless started.
  virtual VideoFrame next(Deadline) = 0;
  /// Frames that the sequence numbers say were lost, and damaged ones, since start().
  virtual std::uint64_t dropped() const = 0;
  virtual void stop() noexcept = 0;
};

}  // namespace wheatstone
