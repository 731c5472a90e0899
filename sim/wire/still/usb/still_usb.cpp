#include "sim/wire/still/usb/still_usb.h"

#include "sim/wire/still/little_endian.h"

namespace wheatstone {
namespace {

using End = UsbReply::End;

// Still image class 1.0, section 5.2
constexpr std::uint8_t kClassToHost = 0xa1, kClassToDevice = 0x21;
constexpr std::uint8_t kCancel = 0x64, kDeviceReset = 0x66, kDeviceStatus = 0x67;

std::vector<std::uint8_t> octets(std::span<const std::byte> bytes) {
  const auto* first = reinterpret_cast<const std::uint8_t*>(bytes.data());
  return {first, first + bytes.size()};
}

}  // namespace

UsbDescription StillUsbFirmware::description() const {
  UsbDescription d;
  d.vendor = 0x054c;
  d.product = product_;
  d.version = 0x0300;
  d.manufacturer = "Sony";
  d.model = "ILCE-7RM3";
  d.serial = camera_.options().serial;
  d.high_speed = true;
  d.interfaces = {{6,
                   1,
                   1,
                   {{kBulkIn, UsbEndpoint::Type::kBulk, PtpCameraFirmware::kPacketBytes},
                    {kBulkOut, UsbEndpoint::Type::kBulk, PtpCameraFirmware::kPacketBytes},
                    {kEvents, UsbEndpoint::Type::kInterrupt, 64}}}};
  return d;
}

UsbReply StillUsbFirmware::control(const UsbSetup& setup, std::span<const std::uint8_t> data,
                                   Nanoseconds now) {
  if (setup.request_type == kClassToDevice && setup.request == kDeviceReset) {
    camera_.reset();
    return {};
  }
  if (setup.request_type == kClassToDevice && setup.request == kCancel) return {};
  if (setup.request_type == kClassToHost && setup.request == kDeviceStatus) {
    std::vector<std::byte> status;
    append(status, std::uint16_t{4});
    append(status, static_cast<std::uint16_t>(camera_.exposing(now) ? ptp::kBusy : ptp::kOk));
    return {End::kDone, octets(status)};
  }
  return UsbFirmware::control(setup, data, now);
}

UsbReply StillUsbFirmware::receive(std::uint8_t endpoint, std::span<const std::uint8_t> bytes,
                                   Nanoseconds now) {
  if (meet)
    if (const auto end = meet(endpoint)) return {*end, {}};
  camera_.receive(std::as_bytes(bytes), now);
  return {camera_.halted() ? End::kStall : End::kDone, {}};
}

UsbReply StillUsbFirmware::send(std::uint8_t endpoint, std::size_t longest, Nanoseconds now) {
  if (meet)
    if (const auto end = meet(endpoint)) return {*end, {}};
  if (endpoint == kBulkIn && camera_.halted()) return {End::kStall, {}};
  const auto bytes =
      endpoint == kEvents ? camera_.interrupt_in(now) : camera_.bulk_in(longest, now);
  if (!bytes) return {End::kNothingYet, {}};
  return {End::kDone, octets(*bytes)};
}

}  // namespace wheatstone
