#pragma once
// A USB device without the wire: transfers in, answers out, in time that is handed in.

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "core/clock.h"

namespace wheatstone {

struct UsbEndpoint {
  enum class Type : std::uint8_t { kBulk = 2, kInterrupt = 3 };
  std::uint8_t address;  // bit 7: to the host
  Type type = Type::kBulk;
  std::uint16_t packet_bytes = 64;
};

struct UsbInterface {
  std::uint8_t device_class, subclass, protocol;
  std::vector<UsbEndpoint> endpoints;
};

/// What the descriptors say: one configuration, with interfaces 0, 1, ... without alternatives.
struct UsbDescription {
  std::uint16_t vendor = 0, product = 0, version = 0;
  std::string manufacturer, model, serial;  // ASCII; empty: none
  std::vector<UsbInterface> interfaces;
  bool high_speed = false;

  std::vector<std::uint8_t> device_descriptor() const;
  std::vector<std::uint8_t> configuration_descriptor() const;
  std::vector<std::uint8_t> string_descriptor(std::uint8_t index) const;  // none: empty
};

/// The first eight bytes of a control transfer (USB 2.0, 9.3).
struct UsbSetup {
  std::uint8_t request_type = 0, request = 0;
  std::uint16_t value = 0, index = 0, length = 0;
  bool to_host() const { return request_type & 0x80; }
};

/// How a transfer ends.
struct UsbReply {
  enum class End {
    kDone,
    kNothingYet,  // it stays pending and is tried again; its bytes count as not received
    kStall,       // endpoints other than 0 are halted until the host clears that
    kError,       // of transmission
    kUnplugged,   // and with it the whole device
  };
  End end = End::kDone;
  std::vector<std::uint8_t> bytes;  // to the host
};

/// One transfer at a time, never from two threads at once.
class UsbFirmware {
 public:
  static constexpr Nanoseconds kNever = std::numeric_limits<Nanoseconds>::max();

  virtual ~UsbFirmware() = default;
  virtual UsbDescription description() const = 0;
  /// `data` comes from the host; what goes to it is cut to setup.length. This one answers the
  /// standard requests that a host makes, and stalls all others.
  virtual UsbReply control(const UsbSetup&, std::span<const std::uint8_t> data, Nanoseconds now);
  /// All bytes of one transfer to the device.
  virtual UsbReply receive(std::uint8_t endpoint, std::span<const std::uint8_t> bytes,
                           Nanoseconds now);
  /// One transfer to the host, which ends early if it is shorter than `longest`. Is asked only
  /// while the host waits for it.
  virtual UsbReply send(std::uint8_t endpoint, std::size_t longest, Nanoseconds now);
  /// The host has cleared the halt of an endpoint, or reset the device.
  virtual void halt_cleared(std::uint8_t /*endpoint*/) {}
  virtual void reset() {}
  /// When pending transfers have to be tried again if nothing else happens.
  virtual Nanoseconds next_event() const { return kNever; }
};

}  // namespace wheatstone
