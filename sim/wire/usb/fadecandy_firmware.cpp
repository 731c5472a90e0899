#include "sim/wire/usb/fadecandy_firmware.h"

#include <algorithm>
#include <cmath>

namespace wheatstone {
namespace {

constexpr std::size_t kPacket = 64, kPixels = 512, kTable = 257;
constexpr std::uint8_t kFinal = 0x20, kIndex = 0x1f, kNoDither = 0x01;
constexpr std::size_t kLastIndex = 24;
enum Type : std::uint8_t { kVideo = 0, kLut = 1, kConfiguration = 2 };

}  // namespace

UsbDescription FadecandyFirmware::description() const {
  UsbDescription d;
  d.vendor = 0x1d50;
  d.product = 0x607a;
  d.version = options_.version;
  d.manufacturer = "scanlime";
  d.model = options_.model;
  d.serial = options_.serial;
  d.interfaces = {{0xff, 0, 0, {{0x01, UsbEndpoint::Type::kBulk, kPacket}}}, {0xfe, 1, 1, {}}};
  return d;
}

UsbReply FadecandyFirmware::control(const UsbSetup& setup, std::span<const std::uint8_t> data,
                                    Nanoseconds now) {
  if (silent || mute) return {UsbReply::End::kNothingYet, {}};
  const bool counter = setup.request_type == 0xc0 && setup.request == 1 && setup.index <= 1;
  if (!counter) return UsbFirmware::control(setup, data, now);
  if (!options_.counts_frames || stops_counting) return {UsbReply::End::kStall, {}};
  UsbReply reply;
  for (std::size_t i = 0; i < counter_bytes; ++i)
    reply.bytes.push_back(i < 4 ? static_cast<std::uint8_t>(frames_ >> (8 * i)) : 0);
  return reply;
}

UsbReply FadecandyFirmware::receive(std::uint8_t, std::span<const std::uint8_t> bytes,
                                    Nanoseconds now) {
  if (silent) return {UsbReply::End::kNothingYet, {}};
  if (late_ns > 0) {
    if (next_event_ns_ == kNever) next_event_ns_ = now + late_ns;
    if (now < next_event_ns_) return {UsbReply::End::kNothingYet, {}};
    next_event_ns_ = kNever;
  }
  if (errors > 0) {
    --errors;
    return {UsbReply::End::kError, {}};
  }
  if (stalls > 0) {
    --stalls;
    // The first part arrives before it.
    for (std::size_t at = 0; at + kPacket <= bytes.size() / 2; at += kPacket)
      packet(bytes.subspan(at, kPacket));
    return {UsbReply::End::kStall, {}};
  }
  for (std::size_t at = 0; at + kPacket <= bytes.size(); at += kPacket) {
    if (unplugs_after == 0) return {UsbReply::End::kUnplugged, {}};
    if (unplugs_after > 0) --unplugs_after;
    packet(bytes.subspan(at, kPacket));
  }
  return {};
}

void FadecandyFirmware::packet(std::span<const std::uint8_t> bytes) {
  const std::uint8_t type = bytes[0] >> 6;
  const std::size_t index = bytes[0] & kIndex;
  const bool final = bytes[0] & kFinal;
  if (loses_frames || index > kLastIndex) return;
  if (type == kVideo) {
    std::copy(bytes.begin() + 1, bytes.end(),
              frame_.begin() + static_cast<std::ptrdiff_t>(index * (kPacket - 1)));
    if (!final) return;
    ++frames_;
    show();
  } else if (type == kLut) {
    for (std::size_t i = 0; i < 31; ++i)
      new_table_[index * 31 + i] =
          static_cast<std::uint16_t>(bytes[2 + 2 * i] | bytes[3 + 2 * i] << 8);
    if (!final) return;
    table_ = new_table_;
    show();
  } else if (type == kConfiguration) {
    configuration_ = bytes[1];
  }
}

/// Codes become 16 bits by repetition, and are looked up between two entries of the table. The LEDs
/// take 8 bits; dithering in time makes the rest of it, and without that it is rounded.
void FadecandyFirmware::show() {
  std::vector<LedCeiling::Rgb> drive(kPixels);
  for (std::size_t p = 0; p < kPixels; ++p)
    for (std::size_t c = 0; c < 3; ++c) {
      const unsigned input = 257U * frame_[3 * p + c];
      const std::uint16_t* entry = &table_[c * kTable + (input >> 8)];
      const unsigned part = input & 0xff;
      const double value = (entry[0] * (256 - part) + entry[1] * part) / (256.0 * 65535);
      drive[p][c] = configuration_ & kNoDither ? std::round(255 * value) / 255 : value;
    }
  ceiling_.drive(drive);
}

}  // namespace wheatstone
