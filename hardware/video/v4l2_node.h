#pragma once
// An open video node: its ioctls with our errors.

#include <atomic>
#include <filesystem>
#include <string>

#include "core/clock.h"
#include "hardware/device_error.h"

namespace wheatstone {

/// Open, and locked against a second opening of ours, from construction to destruction. The kernel
/// does not let an ioctl be broken off: a camera may hold one up (UVC: by 5 s at most) beyond the
/// deadline, which is looked at in between.
class V4l2Node {
 public:
  /// `what` names the camera in errors. Throws kNotFound, kPermission, kBusy, kFault.
  V4l2Node(const std::string& what, const std::filesystem::path&);
  ~V4l2Node();
  V4l2Node(const V4l2Node&) = delete;
  V4l2Node& operator=(const V4l2Node&) = delete;

  const std::string& what() const { return what_; }
  int handle() const { return handle_; }

  /// Throws what a refusal means; `doing` completes "<what> cannot ...".
  void call(unsigned long request, void* argument, const char* doing, const Deadline&);
  /// The same, but returns errno where the camera merely says no: EINVAL, ENOTTY, ENODATA, EAGAIN.
  /// For questions that may be asked in vain.
  int ask(unsigned long request, void* argument, const char* doing);
  /// Whatever it answers.
  void call_quietly(unsigned long request, void* argument) noexcept;

  /// Throws kDisconnected, from now on.
  [[noreturn]] void lost(const std::string& how);
  void require_connected() const;
  /// Throws kTimeout or Cancelled if it is due.
  void check(const Deadline&) const;
  [[noreturn]] void fail(int error, const std::string& doing);

 private:
  std::string what_;
  int handle_ = -1;
  std::atomic<bool> lost_ = false;
};

}  // namespace wheatstone
