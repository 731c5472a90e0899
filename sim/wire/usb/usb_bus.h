#pragma once
// Emulated USB devices that any client of usbfs (libusb and what is built on it) finds, under
// umockdev-wrapper.

#include <functional>
#include <memory>
#include <string>

#include "sim/wire/mock/mock_bed.h"
#include "sim/wire/usb/usb_firmware.h"

namespace wheatstone {

/// A firmware in a socket of bus 1. Each is a device of its own, with the next free address. Time
/// is the machine's. Everything here may be called from any thread, but not from the firmware.
class UsbDevicePeer {
 public:
  /// `port`: "1", or "1.2" behind a hub. Throws DeviceError kFault.
  UsbDevicePeer(MockBed&, UsbFirmware&, const std::string& port = "1");
  ~UsbDevicePeer();
  UsbDevicePeer(const UsbDevicePeer&) = delete;
  UsbDevicePeer& operator=(const UsbDevicePeer&) = delete;

  std::string node() const;  // "/dev/bus/usb/001/005"

  /// Looks at or changes the firmware between two transfers; then pending ones are tried again.
  void with_firmware(const std::function<void()>&);

  // Faults.
  void unplug();
  /// Claims of interfaces end with this errno; 0: as they should.
  void refuse_claims(int error);
  /// Only root may open it from now on.
  void forbid();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheatstone
