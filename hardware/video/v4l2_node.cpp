#include "hardware/video/v4l2_node.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr const char* kAgain = "unplug it and plug it in again";

int ioctl_whole(int handle, unsigned long request, void* argument) {
  int result = 0;
  do result = ::ioctl(handle, request, argument);
  while (result < 0 && errno == EINTR);
  return result < 0 ? errno : 0;
}

bool means_gone(int error) {
  return error == ENODEV || error == ENXIO || error == ESHUTDOWN;
}

}  // namespace

V4l2Node::V4l2Node(const std::string& what, const std::filesystem::path& path) : what_(what) {
  std::error_code none;
  const std::filesystem::path real = std::filesystem::canonical(path, none);
  handle_ = ::open((none ? path : real).c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (handle_ < 0) {
    const int error = errno;
    if (error == ENOENT || error == ENOTDIR || means_gone(error))
      throw DeviceError(Kind::kNotFound, what_ + " is not there",
                        "plug it in, or correct its address in the rig file");
    fail(error, "be opened");
  }
  if (::flock(handle_, LOCK_EX | LOCK_NB) != 0) {
    ::close(handle_);
    fail(EBUSY, "be opened");
  }
}

V4l2Node::~V4l2Node() {
  ::close(handle_);
}

void V4l2Node::lost(const std::string& how) {
  lost_ = true;
  throw DeviceError(Kind::kDisconnected, fmt::format("{} is disconnected ({})", what_, how),
                    "plug it in again, then run the command again");
}

void V4l2Node::require_connected() const {
  if (lost_)
    throw DeviceError(Kind::kDisconnected, what_ + " was disconnected",
                      "plug it in again, then run the command again");
}

void V4l2Node::check(const Deadline& deadline) const {
  if (deadline.cancel.stop_requested()) throw Cancelled(what_ + ": stopped on request");
  if (SteadyClock().now_ns() >= deadline.at_ns)
    throw DeviceError(Kind::kTimeout, what_ + " did not answer in time",
                      "check its cable and trigger, then run the command again");
}

void V4l2Node::fail(int error, const std::string& doing) {
  if (means_gone(error)) lost(std::strerror(error));
  const std::string problem = fmt::format("{} cannot {} ({})", what_, doing, std::strerror(error));
  switch (error) {
    case EBUSY:
      throw DeviceError(Kind::kBusy, problem, "end the other program that uses it");
    case EACCES:
    case EPERM:
      throw DeviceError(Kind::kPermission, problem,
                        "install the udev rules of wheatstone and join the group video");
    case ERANGE:
      throw DeviceError(Kind::kOutOfRange, problem, "ask for what the camera offers");
    case ENOSPC:
      throw DeviceError(Kind::kRefused, problem,
                        "the USB bus has no room for it: use another port or a smaller mode");
    case EINVAL:
    case ENOTTY:
    case ENOMEM:
    case EAGAIN:
      throw DeviceError(Kind::kRefused, problem, "choose another mode or way of transfer");
    default:
      throw DeviceError(Kind::kFault, problem, kAgain);
  }
}

void V4l2Node::call(unsigned long request, void* argument, const char* doing,
                    const Deadline& deadline) {
  require_connected();
  check(deadline);
  if (const int error = ioctl_whole(handle_, request, argument)) fail(error, doing);
}

int V4l2Node::ask(unsigned long request, void* argument, const char* doing) {
  require_connected();
  const int error = ioctl_whole(handle_, request, argument);
  if (error != 0 && error != EINVAL && error != ENOTTY && error != ENODATA && error != EAGAIN)
    fail(error, doing);
  return error;
}

void V4l2Node::call_quietly(unsigned long request, void* argument) noexcept {
  ioctl_whole(handle_, request, argument);
}

}  // namespace wheatstone
