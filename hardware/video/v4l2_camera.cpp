#include "hardware/video/v4l2_camera.h"

#include <fmt/format.h>
#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "hardware/transport/transcript.h"
#include "hardware/video/v4l2_controls.h"
#include "hardware/video/v4l2_list.h"
#include "hardware/video/v4l2_modes.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr Nanoseconds kStopCheckNs = 40'000'000;
constexpr std::size_t kMostImageBytes = std::size_t{256} << 20;
constexpr int kMostPixels = 1 << 14;  // a side

const std::filesystem::path& address(const V4l2CameraSettings& s) {
  if (s.node.empty())
    throw ArgumentError("a video camera has no address",
                        "name its USB serial, or its link in /dev/v4l/by-id");
  return s.node;
}

V4l2CameraSettings checked(V4l2CameraSettings s) {
  if (s.buffers < 2 || s.buffers > 32)
    throw ArgumentError(fmt::format("a video camera cannot use {} buffers", s.buffers),
                        "use 2 to 32");
  if (!s.usb_serial.empty()) s.node = find_video_node(s.usb_serial);
  return s;
}

bool limited_range(const v4l2_pix_format& f) {
  if (f.priv != V4L2_PIX_FMT_PRIV_MAGIC || f.quantization == V4L2_QUANTIZATION_DEFAULT)
    return f.colorspace != V4L2_COLORSPACE_JPEG;
  return f.quantization == V4L2_QUANTIZATION_LIM_RANGE;
}

}  // namespace

V4l2Camera::V4l2Camera(const V4l2CameraSettings& settings)
    : settings_(checked(settings)),
      node_("the video camera at " + address(settings_).string(), settings_.node) {
  identify();
}

V4l2Camera::~V4l2Camera() {
  stop();
}

void V4l2Camera::identify() {
  v4l2_capability about{};
  const auto no_camera = [&] {
    return DeviceError(Kind::kNotFound, node_.what() + " captures no video",
                       "use the camera's capturing node, mostly the one whose link ends in index0");
  };
  if (node_.ask(VIDIOC_QUERYCAP, &about, "tell what it is") != 0) throw no_camera();
  const std::uint32_t can =
      about.capabilities & V4L2_CAP_DEVICE_CAPS ? about.device_caps : about.capabilities;
  const std::uint32_t way =
      settings_.transfer == V4l2Transfer::kRead ? V4L2_CAP_READWRITE : V4L2_CAP_STREAMING;
  if (!(can & V4L2_CAP_VIDEO_CAPTURE)) throw no_camera();
  if (!(can & way))
    throw DeviceError(Kind::kRefused, node_.what() + " does not transfer pictures in this way",
                      "choose another transfer in the rig file");
  const auto text = [](const auto& field) {
    const auto* begin = reinterpret_cast<const char*>(field);
    return printable({begin, ::strnlen(begin, sizeof field)});
  };
  identity_ = {"v4l2", text(about.card), usb_serial_of(settings_.node),
               fmt::format("{} {}.{}.{}", text(about.driver), about.version >> 16,
                           about.version >> 8 & 0xff, about.version & 0xff),
               settings_.node.string()};
}

std::vector<VideoMode> V4l2Camera::modes(Deadline deadline) {
  return list_modes(node_, deadline);
}

VideoSettings V4l2Camera::configure(const VideoMode& mode, Duration exposure, double gain,
                                    Deadline deadline) {
  node_.require_connected();
  if (started_) throw DeviceError(Kind::kNotReady, node_.what() + " is running", "stop it first");
  const std::vector<VideoMode> offered = modes(deadline);
  if (std::none_of(offered.begin(), offered.end(), [&](const VideoMode& m) {
        return m.format == mode.format && m.width_px == mode.width_px &&
               m.height_px == mode.height_px &&
               std::abs(m.frames_per_s - mode.frames_per_s) <= 1e-3 * m.frames_per_s;
      }))
    throw DeviceError(
        Kind::kOutOfRange,
        fmt::format("{} has no mode '{}' {}x{} at {:g}/s", node_.what(), printable(mode.format),
                    mode.width_px, mode.height_px, mode.frames_per_s),
        "use one of its modes");
  require_within_limits(node_, exposure, gain, deadline);

  configured_ = false;
  buffers_.reset();  // while it has some, the kernel lets no format be set
  granted_.mode = set_format(mode, deadline);
  granted_.mode.frames_per_s = set_rate(mode.frames_per_s, deadline);
  switch_automatics_off(node_, deadline);
  granted_.exposure = set_exposure(node_, exposure, deadline);
  granted_.gain = set_gain(node_, gain, deadline);
  configured_ = true;
  return granted_;
}

VideoMode V4l2Camera::set_format(const VideoMode& mode, const Deadline& deadline) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  v4l2_pix_format& f = format.fmt.pix;
  f.width = static_cast<std::uint32_t>(mode.width_px);
  f.height = static_cast<std::uint32_t>(mode.height_px);
  f.pixelformat = fourcc(mode.format);
  f.field = V4L2_FIELD_NONE;
  f.priv = V4L2_PIX_FMT_PRIV_MAGIC;
  node_.call(VIDIOC_S_FMT, &format, "be set to this mode", deadline);

  const std::string granted = fourcc_name(f.pixelformat);
  if (!is_known_format(granted))
    throw DeviceError(Kind::kFault,
                      fmt::format("{} was asked for '{}' and gives '{}'", node_.what(), mode.format,
                                  printable(granted)),
                      "choose another mode");
  const bool sane = f.width > 0 && f.width <= kMostPixels && f.height > 0 &&
                    f.height <= kMostPixels && f.sizeimage > 0 && f.sizeimage <= kMostImageBytes;
  const std::size_t least = sane ? least_bytes_per_line(granted, static_cast<int>(f.width)) : 0;
  if (!sane || f.bytesperline < least ||
      (least > 0 && (f.height - 1) * std::size_t{f.bytesperline} + least > f.sizeimage))
    throw DeviceError(Kind::kProtocol,
                      fmt::format("{} describes pictures that cannot be: {}x{}, {} bytes a line, "
                                  "{} bytes",
                                  node_.what(), f.width, f.height, f.bytesperline, f.sizeimage),
                      "update its kernel driver");
  layout_ = {granted, static_cast<int>(f.width), static_cast<int>(f.height), f.bytesperline,
             !limited_range(f)};
  image_bytes_ = f.sizeimage;
  return {granted, layout_.width_px, layout_.height_px, 0};
}

double V4l2Camera::set_rate(double frames_per_s, const Deadline& deadline) {
  if (frames_per_s == 0) return 0;  // a camera that does not say
  v4l2_streamparm rate{};
  rate.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  v4l2_fract& period = rate.parm.capture.timeperframe;
  period = {1'000'000, static_cast<std::uint32_t>(std::lround(1e6 * frames_per_s))};
  node_.call(VIDIOC_S_PARM, &rate, "be set to this rate", deadline);
  return period.numerator ? static_cast<double>(period.denominator) / period.numerator : 0;
}

void V4l2Camera::start(Deadline deadline) {
  node_.require_connected();
  if (!configured_)
    throw DeviceError(Kind::kNotReady, node_.what() + " has no mode", "configure it first");
  if (started_) return;
  node_.check(deadline);
  buffers_.reset();
  buffers_ = std::make_unique<V4l2Buffers>(node_, settings_.transfer, image_bytes_,
                                           settings_.buffers, deadline);
  buffers_->start(deadline);
  dropped_ = 0;
  any_frame_ = false;
  last_stamp_ns_ = 0;
  started_ = true;
}

void V4l2Camera::stop() noexcept {
  if (started_.exchange(false)) buffers_->stop();
}

void V4l2Camera::restart(const Deadline& deadline) {
  buffers_->stop();
  buffers_->start(deadline);
  any_frame_ = false;
}

void V4l2Camera::require_started() const {
  node_.require_connected();
  if (!started_)
    throw DeviceError(Kind::kNotReady, node_.what() + " is not running", "start it first");
}

bool V4l2Camera::wait(const Deadline& deadline) {
  const Nanoseconds left = deadline.at_ns - SteadyClock().now_ns();
  const timespec slice{0, static_cast<long>(std::clamp<Nanoseconds>(left, 0, kStopCheckNs))};
  pollfd events{node_.handle(), POLLIN, 0};
  const int ready = ::ppoll(&events, 1, &slice, nullptr);
  require_started();  // stop() wakes it
  if (ready < 0 && errno != EINTR) node_.fail(errno, "be waited for");
  if (ready > 0 && !(events.revents & POLLIN)) node_.lost("hung up");
  return ready > 0;
}

void V4l2Camera::nap(const Deadline& deadline) {
  const double period_s = granted_.mode.frames_per_s > 0 ? 1 / granted_.mode.frames_per_s : 0.01;
  const auto nap_ns = static_cast<Nanoseconds>(1e9 * std::clamp(period_s / 4, 0.001, 0.01));
  SteadyClock clock;
  clock.wait_until(std::min(deadline.at_ns, clock.now_ns() + nap_ns));
}

VideoFrame V4l2Camera::next(Deadline deadline) {
  for (bool said_ready = false;;) {
    require_started();
    node_.check(deadline);
    const std::optional<V4l2Filled> filled = buffers_->take();
    if (!filled) {
      if (said_ready) nap(deadline);  // ready and then not is legal; it must not keep a core busy
      said_ready = wait(deadline);
      continue;
    }
    said_ready = false;
    if (filled->failed) {
      ++dropped_;
      nap(deadline);
      restart(deadline);
      continue;
    }
    count_gap(filled->sequence);
    VideoFrame frame;
    std::optional<cv::Mat> pixels;
    if (!(filled->flags & V4L2_BUF_FLAG_ERROR)) pixels = decode(layout_, filled->bytes);
    stamp(*filled, frame);
    buffers_->give_back(filled->index, deadline);
    if (!pixels) {
      ++dropped_;
      nap(deadline);
      continue;
    }
    frame.pixels = std::move(*pixels);
    frame.format = layout_.format;
    frame.sequence = filled->sequence;
    return frame;
  }
}

void V4l2Camera::count_gap(std::uint32_t sequence) {
  // Wraps; a number that goes back says nothing about frames lost.
  const std::uint32_t step = sequence - last_sequence_;
  if (any_frame_ && step > 1 && step <= std::numeric_limits<std::uint32_t>::max() / 2)
    dropped_ += step - 1;
  any_frame_ = true;
  last_sequence_ = sequence;
}

void V4l2Camera::stamp(const V4l2Filled& filled, VideoFrame& frame) {
  const auto half_ns = static_cast<Nanoseconds>(5e8 * granted_.exposure.value());
  const Nanoseconds now = SteadyClock().now_ns();
  const bool monotonic =
      (filled.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  if (!monotonic || filled.stamp_ns <= last_stamp_ns_ || filled.stamp_ns > now) {
    frame.mid_exposure_ns = now - half_ns;
    frame.time_is_the_cameras = false;
    return;
  }
  last_stamp_ns_ = filled.stamp_ns;
  const bool of_start =
      (filled.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  frame.mid_exposure_ns = filled.stamp_ns + (of_start ? half_ns : -half_ns);
}

}  // namespace wheatstone
