#pragma once
// A USB HID device with feature reports, through hidapi on the kernel's hidraw nodes. hidapi's
// other back-end, on libusb, must not be linked: it takes the device away from the kernel.

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "core/clock.h"
#include "hardware/device_error.h"
#include "hardware/transport/transcript.h"

struct hid_device_;  // hidapi's

namespace wheatstone {

/// A HID device that is plugged in. Texts are as it says them, '?' for other than printable ASCII.
struct HidFound {
  std::filesystem::path node;  // "/dev/hidraw3"; changes with every plug
  std::string product, serial;
};
/// Those with this USB id, in the order of their nodes. Opens none.
std::vector<HidFound> list_hid_devices(std::uint16_t vendor, std::uint16_t product);

/// Open from construction to destruction. Transfers run on a thread of its own, since the kernel
/// lets none be broken off: a call keeps its deadline even where the device keeps the kernel
/// waiting (5 s at most, and so long does the destructor wait). What was given up goes on in the
/// kernel; its answer is dropped, and the next transfer comes after it.
/// Deadlines are on the machine's monotonic clock. One thread at a time, but for send_now().
/// Errors of all calls with a deadline: kTimeout, kDisconnected (sticky), kRefused for a transfer
/// that the device stalls, kFault for one that fails otherwise, Cancelled.
class HidDevice {
 public:
  enum class Use {
    kOwn,   // nobody else who asks for it may have it; hidraw does not stop those who do not ask
    kLook,  // whoever has it
  };
  /// `what` names the device in errors ("the relay board on /dev/hidraw3"). Throws kNotFound,
  /// kPermission, kBusy, kFault.
  HidDevice(const std::string& what, const std::filesystem::path& node, Use,
            std::shared_ptr<Transcript> = nullptr);
  ~HidDevice();
  HidDevice(const HidDevice&) = delete;
  HidDevice& operator=(const HidDevice&) = delete;

  const std::string& what() const { return what_; }
  const std::filesystem::path& node() const { return node_; }
  /// Somebody owns it. Pre: opened to look.
  bool owned() const;

  /// A report to the device. Its first byte is the report's number, 0 where the device has none.
  /// kRefused after a send_now() until allow_sends().
  void send_feature(std::string_view report, const Deadline&);
  /// A report from the device, as the kernel hands it over, at most `longest` bytes.
  std::string get_feature(std::uint8_t number, std::size_t longest, const Deadline&);

  /// From any thread: goes before all that waits, and nothing that was ordered before goes after
  /// it. Waits for it, but not for a slow transfer that is under way.
  void send_now(std::string_view report) noexcept;
  /// Returns whether they were.
  bool allow_sends();
  bool sends_allowed() const;

  /// Throws kDisconnected, kTimeout or Cancelled if it is due.
  void check(const Deadline&) const;

 private:
  struct Transfer {
    std::string bytes;
    bool get = false;
    bool done = false;
    int error = 0;  // errno
  };

  void work(const std::stop_token&);
  void carry_out(Transfer&);
  std::string perform(const std::shared_ptr<Transfer>&, const Deadline&);
  [[noreturn]] void fail(int error);
  [[noreturn]] void time_out() const;

  std::string what_;
  std::filesystem::path node_;
  std::shared_ptr<Transcript> transcript_;
  int lock_ = -1;                  // a handle of our own: hidapi keeps its own to itself
  hid_device_* device_ = nullptr;  // of the thread

  mutable std::mutex mutex_;  // of all below
  std::condition_variable_any changed_;
  std::deque<std::shared_ptr<Transfer>> waiting_;
  bool sends_allowed_ = true;
  bool lost_ = false;
  std::jthread thread_;
};

}  // namespace wheatstone
