#include "sim/video_camera.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "core/colour.h"
#include "core/random.h"
#include "hardware/device_error.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr std::uint64_t kVideoSeed = 0x766964656fULL;  // apart from the other devices' noise
constexpr double kBlackDn = 64, kWhiteDn = 4095;
constexpr double kDnPerCdM2S = 300;  // at gain 1
constexpr double kDnPerElectron = 0.25, kReadNoiseDn = 2;
constexpr double kFocalPerWidth = 1.1;
const Eigen::Vector3d kCentreRsbMm(185, 230, 640), kLooksAtRsbMm(185, 120, 0);

Eigen::Matrix3f R_rsb_video() {
  const Eigen::Vector3d forward = (kLooksAtRsbMm - kCentreRsbMm).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitY()).normalized();
  Eigen::Matrix3d R;
  R << right, forward.cross(right), forward;
  return R.cast<float>();
}

DeviceError not_ready(const char* problem, const char* remedy) {
  return {Kind::kNotReady, std::string("the simulated video camera ") + problem, remedy};
}

}  // namespace

cv::Mat1f VideoSensor::trace(cv::Size size) const {
  constexpr std::array<std::array<float, 2>, 4> kOffsets = {
      {{-0.25F, -0.25F}, {0.25F, -0.25F}, {-0.25F, 0.25F}, {0.25F, 0.25F}}};
  const Eigen::Matrix3f R = R_rsb_video();
  const Eigen::RowVector3f luminance = xyz_from_rgb(bt709_primaries()).row(1).cast<float>();
  const auto focal = static_cast<float>(kFocalPerWidth * size.width);
  const float cx = 0.5F * static_cast<float>(size.width - 1),
              cy = 0.5F * static_cast<float>(size.height - 1);
  cv::Mat1f image(size, 0.0F);
  tbb::parallel_for(0, size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      Ray rays[4];
      Eigen::Vector3f rgb[4];
      for (std::size_t i = 0; i < 4; ++i)
        rays[i] = {kCentreRsbMm.cast<float>(),
                   R * Eigen::Vector3f((static_cast<float>(x) + kOffsets[i][0] - cx) / focal,
                                       (static_cast<float>(y) + kOffsets[i][1] - cy) / focal, 1)};
      world_.scene.radiance(rays, 4, world_.light, rgb);
      for (const Eigen::Vector3f& c : rgb) image(y, x) += 0.25F * luminance.dot(c);
    }
  });
  return image;
}

cv::Mat1w VideoSensor::codes(cv::Size size, Duration exposure, double gain, std::uint32_t frame) {
  if (luminance_cd_m2_.size() != size || !(light_ == world_.light)) {
    luminance_cd_m2_ = trace(size);
    light_ = world_.light;
  }
  const double dn_per_cd_m2 = kDnPerCdM2S * exposure.value() * gain;
  const double dn_per_electron = kDnPerElectron * gain, read_noise = kReadNoiseDn * gain;
  cv::Mat1w out(size);
  for (int y = 0; y < size.height; ++y) {
    RandomStream random(world_.seed ^ kVideoSeed,
                        stream_of({frame, static_cast<std::uint64_t>(y)}));
    for (int x = 0; x < size.width; ++x) {
      const double signal = dn_per_cd_m2 * luminance_cd_m2_(y, x);
      const double sigma =
          noise_ ? std::sqrt(signal * dn_per_electron + read_noise * read_noise) : 0;
      const double noise = noise_ ? sigma * random.normal() : 0;
      out(y, x) = static_cast<std::uint16_t>(
          std::clamp(std::round(kBlackDn + signal + noise), 0.0, kWhiteDn));
    }
  }
  return out;
}

cv::Mat video_pixels(const cv::Mat1w& codes, const std::string& format) {
  cv::Mat out;
  if (format == "GREY") {
    out = cv::Mat1b(codes.size());
    std::transform(codes.begin(), codes.end(), out.begin<std::uint8_t>(),
                   [](std::uint16_t v) { return static_cast<std::uint8_t>(v >> 4); });
  } else {
    const int right = format == "Y10 " ? 2 : 0, left = format == "Y16 " ? 4 : 0;
    out = cv::Mat1w(codes.size());
    std::transform(codes.begin(), codes.end(), out.begin<std::uint16_t>(),
                   [&](std::uint16_t v) { return static_cast<std::uint16_t>(v >> right << left); });
  }
  return out;
}

const std::vector<VideoMode>& simulated_video_modes() {
  static const std::vector<VideoMode> modes = [] {
    std::vector<VideoMode> out;
    for (const char* format : {"GREY", "Y12 ", "Y16 "})
      for (const int width : {320, 640})
        for (const double rate : {100.0, 60.0, 30.0})
          out.push_back({format, width, width * 3 / 4, rate});
    return out;
  }();
  return modes;
}

Duration offered_video_exposure(Duration exposure) {
  return Duration::of(kVideoExposureStepS * std::round(exposure.value() / kVideoExposureStepS));
}

std::vector<VideoMode> SimulatedVideoCamera::modes(Deadline deadline) {
  world_.faults.meet("video", deadline);
  return simulated_video_modes();
}

VideoSettings SimulatedVideoCamera::configure(const VideoMode& mode, Duration exposure, double gain,
                                              Deadline deadline) {
  world_.faults.meet("video", deadline);
  if (started_) throw not_ready("is running", "stop it first");
  const auto& modes = simulated_video_modes();
  if (std::find(modes.begin(), modes.end(), mode) == modes.end())
    throw DeviceError(Kind::kOutOfRange, "the simulated video camera has no such mode",
                      "use one of its modes");
  if (!(exposure.value() >= kVideoExposureStepS && exposure.value() <= kVideoMaxExposureS) ||
      !(gain >= 0 && gain <= kVideoMaxGain)) {
    std::ostringstream problem;
    problem << "the simulated video camera has no exposure of " << exposure.value() << " s at gain "
            << gain;
    throw DeviceError(Kind::kOutOfRange, problem.str(), "use 0.0001 s to 1 s, and gain 0 to 16");
  }
  settings_ = {mode, offered_video_exposure(exposure), std::round(gain)};
  configured_ = true;
  return settings_;
}

void SimulatedVideoCamera::start(Deadline deadline) {
  world_.faults.meet("video", deadline);
  if (!configured_) throw not_ready("has no mode", "configure it first");
  if (started_) return;
  started_ = true;
  start_ns_ = world_.clock.now_ns();
  next_frame_ = 0;
  dropped_ = 0;
}

VideoFrame SimulatedVideoCamera::next(Deadline deadline) {
  world_.faults.meet("video", deadline);
  if (!started_) throw not_ready("is not running", "start it first");
  // Longer exposures lower the rate.
  const double period_s = std::max(1 / settings_.mode.frames_per_s, settings_.exposure.value());
  const auto begins = [&](std::int64_t frame) {
    return start_ns_ + static_cast<Nanoseconds>(1e9 * period_s * static_cast<double>(frame));
  };
  const auto done = static_cast<std::int64_t>(
      static_cast<double>(world_.clock.now_ns() - start_ns_) / (1e9 * period_s));
  // What there was no room for is lost.
  if (done > next_frame_ + kVideoBuffers) {
    dropped_ += static_cast<std::uint64_t>(done - kVideoBuffers - next_frame_);
    next_frame_ = done - kVideoBuffers;
  }
  if (begins(next_frame_ + 1) > deadline.at_ns) {
    world_.clock.wait_until(deadline.at_ns);
    throw DeviceError(Kind::kTimeout, "the simulated video camera gave no frame in time",
                      "allow at least the time of a frame");
  }
  world_.clock.wait_until(begins(next_frame_ + 1));
  const auto sequence = static_cast<std::uint32_t>(next_frame_);
  VideoFrame frame;
  const cv::Size size(settings_.mode.width_px, settings_.mode.height_px);
  frame.pixels = video_pixels(sensor_.codes(size, settings_.exposure, settings_.gain, sequence),
                              settings_.mode.format);
  frame.format = settings_.mode.format;
  frame.sequence = sequence;
  frame.mid_exposure_ns =
      begins(next_frame_) + static_cast<Nanoseconds>(5e8 * settings_.exposure.value());
  ++next_frame_;
  return frame;
}

}  // namespace wheatstone
