#include "sim/wire/video/video_firmware.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "sim/wire/video/pixel_encoder.h"

namespace wheatstone {
namespace {

constexpr std::array kFormats = {"Y16 ", "GREY", "Y12 ", "Y10 ", "Y10P",
                                 "YUYV", "MJPG", "RGGB", "RG10", "pRAA"};
constexpr std::array<std::array<std::uint32_t, 2>, 2> kSizes = {{{320, 240}, {640, 480}}};
constexpr std::array<std::uint32_t, 3> kRates = {100, 60, 30};
constexpr std::uint32_t kPage = 4096;
constexpr std::uint32_t kMostBuffers = 32;

std::uint32_t code_of(const std::string& f) {
  return v4l2_fourcc(static_cast<unsigned char>(f[0]), static_cast<unsigned char>(f[1]),
                     static_cast<unsigned char>(f[2]), static_cast<unsigned char>(f[3]));
}

const char* name_of(std::uint32_t code) {
  const auto* f = std::find_if(kFormats.begin(), kFormats.end(),
                               [&](const char* name) { return code_of(name) == code; });
  return f == kFormats.end() ? nullptr : *f;
}

template <std::size_t N>
void copy_text(std::uint8_t (&field)[N], const std::string& text) {
  std::memset(field, 0, N);
  std::memcpy(field, text.data(), std::min(text.size(), N - 1));
}

bool is_size(std::uint32_t width, std::uint32_t height) {
  return std::find(kSizes.begin(), kSizes.end(), std::array{width, height}) != kSizes.end();
}

}  // namespace

VideoFirmware::VideoFirmware(World& world, const VideoFirmwareOptions& options)
    : world_(world),
      options_(options),
      sensor_(world, options.noise),
      controls_({{V4L2_CID_EXPOSURE_AUTO, {"Auto Exposure", 0, 3, V4L2_EXPOSURE_APERTURE_PRIORITY}},
                 {V4L2_CID_EXPOSURE_AUTO_PRIORITY, {"Exposure, Dynamic Framerate", 0, 1, 1}},
                 {V4L2_CID_EXPOSURE_ABSOLUTE,
                  {"Exposure Time, Absolute", 1, 10000, 100, V4L2_CID_EXPOSURE_AUTO,
                   V4L2_EXPOSURE_MANUAL}},
                 {V4L2_CID_AUTOGAIN, {"Gain, Automatic", 0, 1, 1}},
                 {V4L2_CID_GAIN, {"Gain", 0, 16, 1, V4L2_CID_AUTOGAIN, 0}},
                 {V4L2_CID_SHARPNESS, {"Sharpness", 0, 6, 3}}}) {
  v4l2_format f{};
  f.fmt.pix.width = kSizes[0][0];
  f.fmt.pix.height = kSizes[0][1];
  f.fmt.pix.pixelformat = code_of("Y16 ");
  try_format(f);
  format_ = f.fmt.pix;
}

int VideoFirmware::ioctl(unsigned long request, void* argument, Nanoseconds now) {
  const int result = answer(request, argument, now);
  return spoil ? spoil(request, argument, result) : result;
}

int VideoFirmware::answer(unsigned long request, void* argument, Nanoseconds now) {
  const auto as = [&]<class T>(T) -> T& { return *static_cast<T*>(argument); };
  switch (request) {
    case VIDIOC_QUERYCAP:
      return capability(as(v4l2_capability{}));
    case VIDIOC_ENUM_FMT:
      return enumerate_format(as(v4l2_fmtdesc{}));
    case VIDIOC_ENUM_FRAMESIZES:
      return enumerate_size(as(v4l2_frmsizeenum{}));
    case VIDIOC_ENUM_FRAMEINTERVALS:
      return enumerate_interval(as(v4l2_frmivalenum{}));
    case VIDIOC_G_FMT:
      as(v4l2_format{}).fmt.pix = format_;
      return 0;
    case VIDIOC_TRY_FMT:
      return try_format(as(v4l2_format{}));
    case VIDIOC_S_FMT:
      if (!buffers_.empty()) return EBUSY;
      if (const int error = try_format(as(v4l2_format{}))) return error;
      format_ = as(v4l2_format{}).fmt.pix;
      return 0;
    case VIDIOC_G_PARM:
    case VIDIOC_S_PARM:
      if (request == VIDIOC_G_PARM)
        as(v4l2_streamparm{}).parm.capture.timeperframe = {
            1, static_cast<std::uint32_t>(frames_per_s_)};
      return set_rate(as(v4l2_streamparm{}));
    case VIDIOC_QUERYCTRL:
      return query_control(as(v4l2_queryctrl{}));
    case VIDIOC_G_CTRL:
      if (!controls_.contains(as(v4l2_control{}).id)) return EINVAL;
      as(v4l2_control{}).value = control(as(v4l2_control{}).id);
      return 0;
    case VIDIOC_S_CTRL:
      return set_control(as(v4l2_control{}));
    case VIDIOC_REQBUFS:
      return request_buffers(as(v4l2_requestbuffers{}));
    case VIDIOC_QUERYBUF:
      return query_buffer(as(v4l2_buffer{}));
    case VIDIOC_QBUF:
      return queue(as(v4l2_buffer{}));
    case VIDIOC_DQBUF:
      return dequeue(as(v4l2_buffer{}), now);
    case VIDIOC_STREAMON:
    case VIDIOC_STREAMOFF:
      if (request == VIDIOC_STREAMON && buffers_.empty()) return EINVAL;
      stream(request == VIDIOC_STREAMON, now);
      return 0;
    default:
      return ENOTTY;
  }
}

int VideoFirmware::capability(v4l2_capability& c) const {
  copy_text(c.driver, "uvcvideo");
  copy_text(c.card, options_.card);
  copy_text(c.bus_info, "usb-0000:00:14.0-3");
  c.version = 6U << 16 | 1U << 8;
  c.device_caps = options_.device_caps;
  c.capabilities = options_.device_caps | V4L2_CAP_DEVICE_CAPS;
  return 0;
}

int VideoFirmware::enumerate_format(v4l2_fmtdesc& f) const {
  if (f.index >= kFormats.size() || f.type != V4L2_BUF_TYPE_VIDEO_CAPTURE) return EINVAL;
  f.pixelformat = code_of(kFormats[f.index]);
  f.flags = std::strcmp(kFormats[f.index], "MJPG") == 0 ? V4L2_FMT_FLAG_COMPRESSED : 0;
  copy_text(f.description, kFormats[f.index]);
  return 0;
}

int VideoFirmware::enumerate_size(v4l2_frmsizeenum& s) const {
  if (s.index >= kSizes.size() || !name_of(s.pixel_format)) return EINVAL;
  s.type = V4L2_FRMSIZE_TYPE_DISCRETE;
  s.discrete = {kSizes[s.index][0], kSizes[s.index][1]};
  return 0;
}

int VideoFirmware::enumerate_interval(v4l2_frmivalenum& i) const {
  if (i.index >= kRates.size() || !name_of(i.pixel_format) || !is_size(i.width, i.height))
    return EINVAL;
  i.type = V4L2_FRMIVAL_TYPE_DISCRETE;
  i.discrete = {1, kRates[i.index]};
  return 0;
}

int VideoFirmware::try_format(v4l2_format& format) const {
  v4l2_pix_format& f = format.fmt.pix;
  if (!name_of(f.pixelformat)) f.pixelformat = code_of(kFormats[0]);
  if (!is_size(f.width, f.height)) {
    f.width = kSizes[0][0];
    f.height = kSizes[0][1];
  }
  const int line = line_bytes(name_of(f.pixelformat), static_cast<int>(f.width));
  f.bytesperline = line ? static_cast<std::uint32_t>(line) + options_.padding_bytes : 0;
  f.sizeimage = line ? f.bytesperline * f.height : 2 * f.width * f.height;
  f.field = V4L2_FIELD_NONE;
  f.colorspace = V4L2_COLORSPACE_SRGB;
  f.quantization = V4L2_QUANTIZATION_LIM_RANGE;
  return 0;
}

int VideoFirmware::set_rate(v4l2_streamparm& p) {
  v4l2_fract& period = p.parm.capture.timeperframe;
  const double asked =
      period.numerator ? static_cast<double>(period.denominator) / period.numerator : 0;
  frames_per_s_ = *std::min_element(kRates.begin(), kRates.end(), [&](double a, double b) {
    return std::abs(a - asked) < std::abs(b - asked);
  });
  p.parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
  period = {1, static_cast<std::uint32_t>(frames_per_s_)};
  return 0;
}

int VideoFirmware::query_control(v4l2_queryctrl& q) const {
  auto it = controls_.find(q.id);
  if (q.id & V4L2_CTRL_FLAG_NEXT_CTRL)
    it = controls_.upper_bound(q.id & ~static_cast<std::uint32_t>(V4L2_CTRL_FLAG_NEXT_CTRL));
  if (it == controls_.end()) return EINVAL;
  const auto& [id, c] = *it;
  q = {};
  q.id = id;
  q.type = V4L2_CTRL_TYPE_INTEGER;
  copy_text(q.name, c.name);
  q.minimum = c.minimum;
  q.maximum = c.maximum;
  q.step = 1;
  q.default_value = c.minimum;
  return 0;
}

int VideoFirmware::set_control(const v4l2_control& s) {
  const auto it = controls_.find(s.id);
  if (it == controls_.end()) return EINVAL;
  Control& c = it->second;
  if (c.held_by && control(c.held_by) != c.off) return EACCES;
  if (s.value < c.minimum || s.value > c.maximum) return ERANGE;
  c.value = s.value;
  return 0;
}

int VideoFirmware::request_buffers(v4l2_requestbuffers& r) {
  if (r.memory != V4L2_MEMORY_MMAP && r.memory != V4L2_MEMORY_USERPTR) return EINVAL;
  if (r.count > 0 && streaming_) return EBUSY;
  stream(false, 0);
  memory_ = r.memory;
  r.count = std::min(r.count, kMostBuffers);
  r.capabilities = V4L2_BUF_CAP_SUPPORTS_MMAP | V4L2_BUF_CAP_SUPPORTS_USERPTR;
  buffers_.assign(r.count, {});
  for (std::uint32_t i = 0; i < r.count; ++i) {
    v4l2_buffer& b = buffers_[i].about;
    b.index = i;
    b.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    b.memory = memory_;
    b.length = format_.sizeimage;
    b.m.offset = i * ((format_.sizeimage + kPage - 1) / kPage * kPage);
  }
  return 0;
}

int VideoFirmware::query_buffer(v4l2_buffer& b) const {
  if (b.index >= buffers_.size()) return EINVAL;
  b = buffers_[b.index].about;
  return 0;
}

int VideoFirmware::queue(v4l2_buffer& b) {
  if (b.index >= buffers_.size() || b.memory != memory_ || buffers_[b.index].queued) return EINVAL;
  Buffer& buffer = buffers_[b.index];
  if (memory_ == V4L2_MEMORY_USERPTR) {
    if (b.length < format_.sizeimage) return EINVAL;
    buffer.about.m.userptr = b.m.userptr;
    buffer.about.length = b.length;
  }
  buffer.queued = true;
  waiting_.push_back(b.index);
  return 0;
}

int VideoFirmware::dequeue(v4l2_buffer& b, Nanoseconds now) {
  if (!streaming_ || b.memory != memory_) return EINVAL;
  advance(now);
  if (done_.empty()) return EAGAIN;
  Buffer& buffer = buffers_[done_.front()];
  done_.pop_front();
  buffer.queued = false;
  b = buffer.about;
  return 0;
}

void VideoFirmware::stream(bool on, Nanoseconds now) {
  if (on == streaming_) return;
  streaming_ = on;
  still_.clear();
  start_ns_ = now;
  frame_ = 0;
  if (on) return;
  waiting_.clear();
  done_.clear();
  for (Buffer& b : buffers_) b.queued = false;
}

void VideoFirmware::advance(Nanoseconds now) {
  for (; streaming_ && !silent && next_picture_ns() <= now; ++frame_) {
    if (waiting_.empty()) continue;
    Buffer& buffer = buffers_[waiting_.front()];
    const auto frame = static_cast<std::uint32_t>(frame_);
    const std::vector<std::uint8_t> bytes = picture(frame);
    const std::size_t n = std::min(bytes.size(), buffer.bytes.size());
    std::copy_n(bytes.begin(), n, buffer.bytes.begin());
    buffer.about.bytesused = static_cast<std::uint32_t>(n);
    buffer.about.sequence = options_.first_sequence + frame;
    buffer.about.flags = options_.stamp_flags;
    const Nanoseconds stamp = start_ns_ + period_ns() * frame_;
    buffer.about.timestamp.tv_sec = stamp / 1'000'000'000;
    buffer.about.timestamp.tv_usec = stamp / 1000 % 1'000'000;
    done_.push_back(waiting_.front());
    waiting_.pop_front();
  }
}

int VideoFirmware::read(std::span<std::uint8_t> out, Nanoseconds now) {
  if (!buffers_.empty()) return -EBUSY;
  if (!streaming_) stream(true, now);
  if (silent || next_picture_ns() > now) return -EAGAIN;
  // Nobody keeps what was not read: the newest it is.
  frame_ = (now - start_ns_) / period_ns() - 1;
  const std::vector<std::uint8_t> bytes = picture(static_cast<std::uint32_t>(frame_++));
  const std::size_t n = std::min(bytes.size(), out.size());
  std::copy_n(bytes.begin(), n, out.begin());
  return static_cast<int>(n);
}

std::vector<std::uint8_t> VideoFirmware::picture(std::uint32_t frame) {
  if (options_.noise || still_.empty() || !(still_light_ == world_.light)) {
    const cv::Size size(static_cast<int>(format_.width), static_cast<int>(format_.height));
    still_ = encode_pixels(sensor_.codes(size, exposure(), control(V4L2_CID_GAIN), frame),
                           name_of(format_.pixelformat), format_.bytesperline);
    still_light_ = world_.light;
  }
  std::vector<std::uint8_t> bytes = still_;
  if (spoil_picture) spoil_picture(bytes);
  return bytes;
}

Duration VideoFirmware::exposure() const {
  return Duration::of(kVideoExposureStepS * control(V4L2_CID_EXPOSURE_ABSOLUTE));
}

Nanoseconds VideoFirmware::period_ns() const {
  return static_cast<Nanoseconds>(1e9 * std::max(1 / frames_per_s_, exposure().value()));
}

}  // namespace wheatstone
