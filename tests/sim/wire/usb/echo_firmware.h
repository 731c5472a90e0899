#pragma once

#include <deque>
#include <vector>

#include "sim/wire/usb/usb_firmware.h"

namespace wheatstone {

/// Sends back what it receives, a word on demand on its interrupt endpoint.
class Echo final : public UsbFirmware {
 public:
  UsbDescription description() const override {
    UsbDescription d;
    d.vendor = 0x1209;
    d.product = 0x0001;
    d.version = 0x0123;
    d.manufacturer = "Wheatstone";
    d.model = "Echo";
    d.serial = "E7";
    d.interfaces = {{0xff,
                     0,
                     0,
                     {{0x01, UsbEndpoint::Type::kBulk, 64},
                      {0x82, UsbEndpoint::Type::kBulk, 64},
                      {0x83, UsbEndpoint::Type::kInterrupt, 8}}}};
    return d;
  }
  UsbReply control(const UsbSetup& s, std::span<const std::uint8_t> data,
                   Nanoseconds now) override {
    if (s.request_type == 0x40 && s.request == 7) {
      held.assign(data.begin(), data.end());
      return {};
    }
    if (s.request_type == 0xc0 && s.request == 7) return {UsbReply::End::kDone, held};
    return UsbFirmware::control(s, data, now);
  }
  UsbReply receive(std::uint8_t, std::span<const std::uint8_t> bytes, Nanoseconds) override {
    if (stall) return {UsbReply::End::kStall, {}};
    if (gone) return {UsbReply::End::kUnplugged, {}};
    queue.emplace_back(bytes.begin(), bytes.end());
    return {};
  }
  UsbReply send(std::uint8_t endpoint, std::size_t, Nanoseconds now) override {
    if (endpoint == 0x83) {
      if (now < event_ns) return {UsbReply::End::kNothingYet, {}};
      event_ns = kNever;
      return {UsbReply::End::kDone, {1, 2}};
    }
    if (queue.empty()) return {UsbReply::End::kNothingYet, {}};
    UsbReply reply{UsbReply::End::kDone, queue.front()};
    queue.pop_front();
    return reply;
  }
  void halt_cleared(std::uint8_t) override { stall = false; }
  Nanoseconds next_event() const override { return event_ns; }

  std::vector<std::uint8_t> held;
  std::deque<std::vector<std::uint8_t>> queue;
  Nanoseconds event_ns = kNever;
  bool stall = false, gone = false;
};

}  // namespace wheatstone
