#include "sim/wire/usb/usb_firmware.h"

#include <algorithm>

namespace wheatstone {
namespace {

using Bytes = std::vector<std::uint8_t>;

// USB 2.0, tables 9-4 and 9-5
constexpr std::uint8_t kGetStatus = 0, kGetDescriptor = 6, kGetConfiguration = 8,
                       kSetConfiguration = 9, kGetInterface = 10;
constexpr std::uint8_t kDevice = 1, kConfiguration = 2, kString = 3, kInterface = 4, kEndpoint = 5;

std::uint8_t low(std::size_t v) {
  return static_cast<std::uint8_t>(v & 0xff);
}
std::uint8_t high(std::size_t v) {
  return static_cast<std::uint8_t>(v >> 8 & 0xff);
}

}  // namespace

Bytes UsbDescription::device_descriptor() const {
  return {18,
          kDevice,
          0x00,
          0x02,  // USB 2.0
          0,
          0,
          0,
          64,
          low(vendor),
          high(vendor),
          low(product),
          high(product),
          low(version),
          high(version),
          static_cast<std::uint8_t>(manufacturer.empty() ? 0 : 1),
          static_cast<std::uint8_t>(model.empty() ? 0 : 2),
          static_cast<std::uint8_t>(serial.empty() ? 0 : 3),
          1};
}

Bytes UsbDescription::configuration_descriptor() const {
  Bytes out = {9, kConfiguration, 0, 0, low(interfaces.size()), 1, 0, 0x80, 250};
  for (std::size_t i = 0; i < interfaces.size(); ++i) {
    const UsbInterface& f = interfaces[i];
    const Bytes head = {9,          kInterface, low(i), 0, low(f.endpoints.size()), f.device_class,
                        f.subclass, f.protocol, 0};
    out.insert(out.end(), head.begin(), head.end());
    for (const UsbEndpoint& e : f.endpoints) {
      const std::uint8_t interval = e.type == UsbEndpoint::Type::kInterrupt ? 8 : 0;
      const Bytes endpoint = {7,
                              kEndpoint,
                              e.address,
                              static_cast<std::uint8_t>(e.type),
                              low(e.packet_bytes),
                              high(e.packet_bytes),
                              interval};
      out.insert(out.end(), endpoint.begin(), endpoint.end());
    }
  }
  out[2] = low(out.size());
  out[3] = high(out.size());
  return out;
}

Bytes UsbDescription::string_descriptor(std::uint8_t index) const {
  if (index == 0) return {4, kString, 0x09, 0x04};  // English
  const std::string text = index == 1   ? manufacturer
                           : index == 2 ? model
                           : index == 3 ? serial
                                        : std::string();
  if (text.empty()) return {};
  Bytes out = {low(2 + 2 * text.size()), kString};
  for (const char c : text) {
    out.push_back(static_cast<std::uint8_t>(c));
    out.push_back(0);
  }
  return out;
}

UsbReply UsbFirmware::control(const UsbSetup& setup, std::span<const std::uint8_t>, Nanoseconds) {
  const UsbReply stall{UsbReply::End::kStall, {}};
  if ((setup.request_type & 0x60) != 0) return stall;  // of a class or vendor
  const auto reply = [&](Bytes bytes) {
    bytes.resize(std::min<std::size_t>(bytes.size(), setup.length));
    return UsbReply{UsbReply::End::kDone, std::move(bytes)};
  };
  if (setup.request == kGetDescriptor && setup.to_host()) {
    const Bytes d = setup.value >> 8 == kDevice          ? description().device_descriptor()
                    : setup.value >> 8 == kConfiguration ? description().configuration_descriptor()
                    : setup.value >> 8 == kString
                        ? description().string_descriptor(low(setup.value))
                        : Bytes();
    return d.empty() ? stall : reply(d);
  }
  if (setup.request == kGetStatus && setup.to_host()) return reply({0, 0});
  if (setup.request == kGetConfiguration) return reply({1});
  if (setup.request == kGetInterface) return reply({0});
  if (setup.request == kSetConfiguration && setup.value == 1) return reply({});
  return stall;
}

UsbReply UsbFirmware::receive(std::uint8_t, std::span<const std::uint8_t>, Nanoseconds) {
  return {UsbReply::End::kStall, {}};
}

UsbReply UsbFirmware::send(std::uint8_t, std::size_t, Nanoseconds) {
  return {UsbReply::End::kNothingYet, {}};
}

}  // namespace wheatstone
