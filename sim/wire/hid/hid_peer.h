#pragma once
// An emulated USB HID device that any program finds in /dev and /sys, under umockdev-wrapper.

#include <filesystem>
#include <functional>
#include <memory>

#include "sim/wire/hid/hid_firmware.h"
#include "sim/wire/mock/mock_bed.h"

namespace wheatstone {

/// A firmware behind a hidraw node, with what the kernel does in between. Time is the machine's.
/// Everything here may be called from any thread.
class HidPeer {
 public:
  /// "/dev/hidraw<number>", number 0..9.
  HidPeer(MockBed&, HidFirmware&, int number = 0);
  ~HidPeer();
  HidPeer(const HidPeer&) = delete;
  HidPeer& operator=(const HidPeer&) = delete;

  std::filesystem::path node() const;

  /// Looks at or changes the firmware between two of its answers.
  void with_firmware(const std::function<void()>&);

  // Faults.
  /// The device does not answer: transfers end after so long as the kernel then ends them
  /// (ETIMEDOUT). 0: it answers again.
  void silence(Duration kernel_gives_up);
  /// Transfers are carried out so much later.
  void delay(Duration);
  void unplug();
  /// When so many more transfers have begun; that one never ends but by this.
  void unplug_after(int transfers);
  /// Nobody but root may open the node any more.
  void forbid();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace wheatstone
