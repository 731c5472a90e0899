#pragma once
// One interface of a USB device, through libusb.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/clock.h"
#include "hardware/device_error.h"

namespace wheatstone {

struct UsbIdentity {
  std::uint16_t vendor = 0, product = 0;
  std::string serial;  // empty: the only one there is
};

/// A device that is plugged in.
struct UsbFound {
  std::string address;  // "usb 1:5": bus and number, another one at each plugging in
  std::string manufacturer, model, serial;
  std::uint16_t version = 0;  // bcdDevice
  std::string trouble;        // why it cannot be opened; empty: it can
};
/// With interface 0 free or not.
std::vector<UsbFound> list_usb_devices(std::uint16_t vendor, std::uint16_t product);

/// The text of a string descriptor; '?' for all that a terminal might obey.
std::string usb_text(std::span<const std::uint8_t> descriptor);

/// The setup of a control transfer (USB 2.0, 9.3).
struct UsbRequest {
  std::uint8_t type = 0, request = 0;
  std::uint16_t value = 0, index = 0;
};

/// Owns the device's handle and one claimed interface. Transfers end with kTimeout, Cancelled
/// (within 50 ms; what has been transferred until then is not known), kDisconnected (from then on
/// always), kRefused (broken off by abort()), kFault (the bus). One that an endpoint stalls is
/// cleared and made once more from its start; then kFault.
class UsbDevice {
 public:
  /// `what` names the device in errors. Throws kNotFound for none or several, kBusy, kPermission.
  UsbDevice(const std::string& what, const UsbIdentity&, int interface);
  ~UsbDevice();
  UsbDevice(const UsbDevice&) = delete;
  UsbDevice& operator=(const UsbDevice&) = delete;

  const UsbFound& about() const;
  void write(std::uint8_t endpoint, std::span<const std::uint8_t>, const Deadline&);
  /// One transfer, `longest` bytes or fewer.
  std::vector<std::uint8_t> read(std::uint8_t endpoint, std::size_t longest, const Deadline&);
  /// The device's answer; none: it stalls, as it does not know the request.
  std::optional<std::vector<std::uint8_t>> ask(const UsbRequest&, std::uint16_t longest,
                                               const Deadline&);

  // From any thread.
  /// Breaks off what another thread transfers.
  void abort() noexcept;
  /// Writes with all that it needs made before. Gives up after a quarter of a second.
  void write_at_once(std::uint8_t endpoint, std::span<const std::uint8_t>) noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheatstone
