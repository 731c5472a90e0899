#include "hardware/usb/fadecandy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr std::uint16_t kVendor = 0x1d50, kProduct = 0x607a, kOldestVersion = 0x0107;
constexpr std::uint8_t kOut = 0x01;
constexpr UsbRequest kKeyFramesReceived{0xc0, 1, 0, 1};
constexpr Duration kOpenLimit = Duration::of(0.6);

FadecandySettings checked(const FadecandySettings& s) {
  require_response(s.response_gamma, s.max_mean_drive);
  require_gamma("code", s.code_gamma);
  return s;
}

}  // namespace

std::vector<int> fadecandy_pixels(const FadecandySettings& s) {
  if (s.leds_per_strand < 1 || s.strand_offset < 0 ||
      s.leds_per_strand + s.strand_offset > kFadecandyStrand)
    throw ArgumentError(fmt::format("{} LEDs from LED {} on do not fit a strand of {}",
                                    s.leds_per_strand, s.strand_offset, kFadecandyStrand),
                        "put fewer LEDs on each strand");
  std::vector<int> pixels = places_on_wire(s.mapping);
  for (int& p : pixels) {
    p = p / s.leds_per_strand * kFadecandyStrand + s.strand_offset + p % s.leds_per_strand;
    if (p >= kFadecandyPixels)
      throw ArgumentError(fmt::format("{} x {} LEDs, {} on a strand, need more than 8 strands",
                                      s.mapping.columns, s.mapping.rows, s.leds_per_strand),
                          "put more LEDs on each strand");
  }
  return pixels;
}

std::vector<UsbFound> list_fadecandies() {
  return list_usb_devices(kVendor, kProduct);
}

Fadecandy::Fadecandy(const FadecandySettings& settings)
    : settings_(checked(settings)),
      pixel_of_led_(fadecandy_pixels(settings)),
      black_(fadecandy_frame({})),
      usb_("the Fadecandy", {kVendor, kProduct, settings.usb_serial}, 0) {
  const std::uint16_t version = usb_.about().version;
  if (version < kOldestVersion)
    throw DeviceError(
        Kind::kFault,
        fmt::format("the Fadecandy has firmware {:x}.{:02x}", version >> 8, version & 0xff),
        "load firmware 1.07 or later into it");
  const Deadline deadline = SteadyClock().in(kOpenLimit);
  usb_.write(kOut, fadecandy_config(settings_.dither, settings_.interpolate), deadline);
  // Dark first: there is no knowing what the controller held when the table changes its meaning.
  usb_.write(kOut, black_, deadline);
  usb_.write(kOut,
             fadecandy_lut(fadecandy_response(settings_.code_gamma, settings_.response_gamma)),
             deadline);
  counts_frames_ = frames_received(deadline).has_value();
}

Fadecandy::~Fadecandy() {
  all_off();
}

DeviceIdentity Fadecandy::identity() const {
  const UsbFound& usb = usb_.about();
  return {"fadecandy", usb.model, usb.serial,
          fmt::format("{:x}.{:02x}", usb.version >> 8, usb.version & 0xff), usb.address};
}

/// None: this firmware does not count.
std::optional<std::uint32_t> Fadecandy::frames_received(const Deadline& deadline) {
  const auto bytes = usb_.ask(kKeyFramesReceived, 4, deadline);
  if (!bytes && counts_frames_)
    throw DeviceError(Kind::kFault, "the Fadecandy no longer counts its frames",
                      "unplug it and plug it in again");
  if (!bytes) return std::nullopt;
  if (bytes->size() != 4)
    throw DeviceError(Kind::kProtocol,
                      fmt::format("the Fadecandy counts frames in {} bytes", bytes->size()),
                      "load firmware 1.07 or later into it");
  std::uint32_t count = 0;
  for (std::size_t i = 4; i-- > 0;) count = count << 8 | (*bytes)[i];
  return count;
}

void Fadecandy::wait_until_received(std::uint32_t frames_before, const Deadline& deadline) {
  constexpr Nanoseconds kShortestNs = 500'000, kLongestNs = 20'000'000;
  SteadyClock clock;
  for (Nanoseconds nap = kShortestNs; frames_received(deadline) == frames_before;
       nap = std::min(2 * nap, kLongestNs)) {
    if (clock.now_ns() + nap >= deadline.at_ns)
      throw DeviceError(Kind::kTimeout, "the Fadecandy took a frame and did not show it",
                        "send it again");
    clock.wait_until(clock.now_ns() + nap);
  }
}

void Fadecandy::set_frame(const LedFrame& frame, Deadline deadline) {
  require_valid(*this, frame);
  const std::uint32_t switched_off = switched_off_;
  FadecandyPixels pixels{};
  std::size_t led = 0;
  for (const cv::Vec3f& rgb : frame.drive) {
    auto& codes = pixels[static_cast<std::size_t>(pixel_of_led_[led++])];
    for (int c = 0; c < 3; ++c)
      codes[static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(
          std::lround(255 * std::pow(static_cast<double>(rgb[c]), 1 / settings_.code_gamma)));
  }
  try {
    std::optional<std::uint32_t> before;
    if (counts_frames_) before = frames_received(deadline);
    usb_.write(kOut, fadecandy_frame(pixels), deadline);
    if (before) wait_until_received(*before, deadline);
  } catch (const DeviceError& e) {
    if (switched_off_ == switched_off || e.kind() == Kind::kDisconnected) throw;
  }
  if (switched_off_ == switched_off) return;
  usb_.write_at_once(kOut, black_);
  throw DeviceError(Kind::kRefused, "the LEDs were switched off before the frame showed",
                    "send it again");
}

void Fadecandy::all_off() noexcept {
  ++switched_off_;
  usb_.abort();
  usb_.write_at_once(kOut, black_);
}

}  // namespace wheatstone
