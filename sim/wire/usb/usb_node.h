#pragma once
// An emulated USB device as the machine shows it to programs: what they find, open and wait for.

#include <cstdint>
#include <string>
#include <vector>

#include "sim/wire/mock/mock_bed.h"
#include "sim/wire/usb/usb_firmware.h"

namespace wheatstone {

/// A device of bus 1 below /sys, and its node below /dev. Not for several threads at once, but for
/// ring() and quiet().
class UsbNode {
 public:
  /// `address`: 1 to 127; `port` as UsbDevicePeer has it. Throws DeviceError kFault.
  UsbNode(MockBed&, const UsbDescription&, unsigned address, const std::string& port);
  ~UsbNode();
  UsbNode(const UsbNode&) = delete;
  UsbNode& operator=(const UsbNode&) = delete;

  const std::string& path() const { return path_; }  // "/dev/bus/usb/001/005"
  /// Tells whoever watches devices that it has come.
  void announce();
  /// Takes it out of the tree and tells so; the node's clients keep what they have open.
  void take_away();

  /// Whoever waits till the node can be written wakes: a transfer has ended.
  void ring() const;
  void quiet() const;

 private:
  MockBed& bed_;
  std::string path_, device_;            // the latter below /sys
  std::vector<std::string> interfaces_;  // below /sys
  int pipe_ = -1;                        // in place of the node
};

}  // namespace wheatstone
