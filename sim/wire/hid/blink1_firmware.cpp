#include "sim/wire/hid/blink1_firmware.h"

#include <algorithm>
#include <mutex>
#include <utility>

namespace wheatstone {
namespace {

constexpr std::uint8_t kReportNumber = 1;
constexpr std::size_t kReport = 9;  // with its number
constexpr Nanoseconds kTimeUnitNs = 10'000'000;

// Vendor page; feature report 1 of eight bytes.
constexpr unsigned char kDescriptor[] = {0x06, 0x00, 0xff, 0x09, 0x01, 0xa1, 0x01, 0x15,
                                         0x00, 0x26, 0xff, 0x00, 0x75, 0x08, 0x85, 0x01,
                                         0x95, 0x08, 0x09, 0x00, 0xb2, 0x02, 0x01, 0xc0};

}  // namespace

Blink1Firmware::Blink1Firmware(World& world, std::string serial)
    : world_(world), serial_(std::move(serial)), last_(kReport, '\0') {
  shine();
}

void Blink1Firmware::go_dark() {
  leds_ = {};
  shine();
}

HidAbout Blink1Firmware::about() const {
  return {0x27b8,         0x01ed,  "ThingM",
          "blink(1) mk2", serial_, std::string(std::begin(kDescriptor), std::end(kDescriptor))};
}

int Blink1Firmware::take(std::uint8_t number, std::string_view bytes, Nanoseconds now) {
  if (number != kReportNumber || bytes.size() < kReport - 1) return EPIPE;
  last_ = bytes.substr(0, kReport);
  last_.resize(kReport, '\0');
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(last_[i]); };
  const Colour colour{static_cast<double>(byte(2)), static_cast<double>(byte(3)),
                      static_cast<double>(byte(4))};
  switch (last_[1]) {
    case 'c':
      fade(byte(7), colour, (256 * byte(5) + byte(6)) * kTimeUnitNs, now);
      break;
    case 'n':
      fade(byte(7), colour, 0, now);
      break;
    case 'r': {
      const Colour c = shown(byte(7) == 2 ? 1 : 0, now);
      for (std::size_t i = 0; i < c.size(); ++i)
        last_[2 + i] = static_cast<char>(static_cast<unsigned char>(c[i]));
      break;
    }
    case 'v':
      std::copy(version.begin(), version.end(), last_.begin() + 3);
      break;
  }
  return 0;
}

int Blink1Firmware::give(std::uint8_t number, std::string& bytes, Nanoseconds) {
  if (number != kReportNumber) return EPIPE;
  bytes = last_;
  return 0;
}

void Blink1Firmware::fade(int led, const Colour& to, Nanoseconds duration, Nanoseconds now) {
  for (std::size_t i = 0; i < leds_.size(); ++i)
    if ((led == 0 || led == static_cast<int>(i) + 1) && !(first_led_broken && i == 0))
      leds_[i] = {shown(i, now), to, now, duration};
  shine();
}

Blink1Firmware::Colour Blink1Firmware::shown(std::size_t led, Nanoseconds now) const {
  const Led& l = leds_[led];
  if (now >= l.start + l.duration) return l.to;
  const double part = static_cast<double>(now - l.start) / static_cast<double>(l.duration);
  Colour c{};
  for (std::size_t i = 0; i < c.size(); ++i) c[i] = l.from[i] + part * (l.to[i] - l.from[i]);
  return c;
}

void Blink1Firmware::shine() {
  const bool lit = std::any_of(leds_.begin(), leds_.end(), [](const Led& l) {
    return std::any_of(l.to.begin(), l.to.end(), [](double c) { return c > 0; });
  });
  const std::lock_guard lock(world_.mutex);
  world_.light.marker_mask = lit ? 1 : 0;
}

}  // namespace wheatstone
