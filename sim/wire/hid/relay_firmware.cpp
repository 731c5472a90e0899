#include "sim/wire/hid/relay_firmware.h"

#include <mutex>
#include <utility>

namespace wheatstone {
namespace {

constexpr std::size_t kReport = 8, kName = 5;
constexpr unsigned char kAllOn = 0xfe, kAllOff = 0xfc, kOn = 0xff, kOff = 0xfd, kRename = 0xfa;

// Vendor page; one feature report of eight bytes.
constexpr unsigned char kDescriptor[] = {0x06, 0x00, 0xff, 0x09, 0x01, 0xa1, 0x01, 0x15,
                                         0x00, 0x26, 0xff, 0x00, 0x75, 0x08, 0x95, 0x08,
                                         0x09, 0x00, 0xb2, 0x02, 0x01, 0xc0};

}  // namespace

RelayFirmware::RelayFirmware(World& world, std::string name, int channels)
    : world_(world), name_(std::move(name)), channels_(channels) {
  name_.resize(kName, ' ');
  light(0);
}

void RelayFirmware::go_dark() {
  stuck = 0;
  light(0);
}

HidAbout RelayFirmware::about() const {
  return {0x16c0,
          0x05df,
          "www.dcttech.com",
          "USBRelay" + std::to_string(channels_),
          "",
          std::string(std::begin(kDescriptor), std::end(kDescriptor))};
}

int RelayFirmware::take(std::uint8_t, std::string_view bytes, Nanoseconds) {
  if (bytes.size() < kReport) return EPIPE;
  const auto channel = static_cast<unsigned char>(bytes[1]);
  const bool there = channel >= 1 && channel <= channels_;
  const auto bit = static_cast<std::uint8_t>(there ? 1U << (channel - 1) : 0);
  const auto all = static_cast<std::uint8_t>((1U << channels_) - 1);
  switch (static_cast<unsigned char>(bytes[0])) {
    case kAllOn:
      light(all);
      break;
    case kAllOff:
      light(0);
      break;
    case kOn:
      light(on_ | bit);
      break;
    case kOff:
      light(static_cast<std::uint8_t>(on_ & ~bit));
      break;
    case kRename:
      name_ = bytes.substr(1, kName);
      break;
  }
  return 0;
}

int RelayFirmware::give(std::uint8_t, std::string& bytes, Nanoseconds) {
  bytes = name_;
  bytes.resize(kReport, '\0');
  bytes.back() = static_cast<char>(on_);
  return 0;
}

void RelayFirmware::light(std::uint8_t wanted) {
  on_ = static_cast<std::uint8_t>((wanted & ~stuck) | (on_ & stuck));
  const std::lock_guard lock(world_.mutex);
  world_.light.marker_mask = on_;
}

}  // namespace wheatstone
