#pragma once
// The simulated alignment camera: small, monochrome, fixed above the rail, looking into the box.

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "hardware/video_camera.h"
#include "sim/world.h"

namespace wheatstone {

inline constexpr double kVideoExposureStepS = 100e-6;  // as V4L2 counts
inline constexpr double kVideoMaxExposureS = 1.0, kVideoMaxGain = 16;
inline constexpr int kVideoBuffers = 4;  // pictures kept for a late caller

/// Its sensor: 12-bit codes, linear in light, shot and read noise from the world's seed. What it
/// gives depends on the light of the box, the settings and the number of the frame alone.
class VideoSensor {
 public:
  explicit VideoSensor(World& world, bool noise = true) : world_(world), noise_(noise) {}
  cv::Mat1w codes(cv::Size, Duration exposure, double gain, std::uint32_t frame);

 private:
  cv::Mat1f trace(cv::Size) const;

  World& world_;
  bool noise_;
  BoxLight light_;  // of the picture kept
  cv::Mat1f luminance_cd_m2_;
};

/// The pixels of a monochrome format that codes of 12 bits give: GREY, Y10, Y12; Y16 left-aligned.
cv::Mat video_pixels(const cv::Mat1w& codes, const std::string& format);

/// "GREY", "Y12 " and "Y16 ", 320x240 and 640x480, 100, 60 and 30/s.
const std::vector<VideoMode>& simulated_video_modes();
/// As the camera rounds it.
Duration offered_video_exposure(Duration);

class SimulatedVideoCamera final : public VideoCamera {
 public:
  explicit SimulatedVideoCamera(World& world, bool noise = true)
      : world_(world), sensor_(world, noise) {}

  DeviceIdentity identity() const override {
    return {"simulated", "twin of the alignment camera", "", "", ""};
  }
  std::vector<VideoMode> modes(Deadline) override;
  /// Exposure: 100 microseconds to 1 s, at most a frame. Gain: 0 to 16, whole.
  VideoSettings configure(const VideoMode&, Duration exposure, double gain, Deadline) override;
  void start(Deadline) override;
  VideoFrame next(Deadline) override;
  std::uint64_t dropped() const override { return dropped_; }
  void stop() noexcept override { started_ = false; }

 private:
  World& world_;
  VideoSensor sensor_;
  VideoSettings settings_;
  bool configured_ = false, started_ = false;
  Nanoseconds start_ns_ = 0;
  std::int64_t next_frame_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace wheatstone
