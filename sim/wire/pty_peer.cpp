#include "sim/wire/pty_peer.h"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/eventfd.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "core/error.h"
#include "hardware/device_error.h"

namespace wheatstone {

namespace fs = std::filesystem;

namespace {

void wake(int event) {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t n = ::write(event, &one, sizeof one);
}

}  // namespace

PtyPeer::PtyPeer(SerialFirmware& firmware, fs::path link, double time_scale)
    : firmware_(firmware), link_(std::move(link)), time_scale_(time_scale) {
  if (!(time_scale > 0)) throw ArgumentError("a time scale is not above 0", "use 1 for real time");
  if (!link_.empty() && fs::exists(fs::symlink_status(link_)) && !fs::is_symlink(link_))
    throw FileError(link_, "is there already and is no symbolic link", "choose another path");
  open_terminal();
  wake_ = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  thread_ = std::thread([this] { loop(); });
}

PtyPeer::~PtyPeer() {
  ending_ = true;
  wake(wake_);
  thread_.join();
  close_terminal();
  ::close(wake_);
}

fs::path PtyPeer::path() const {
  const std::lock_guard lock(mutex_);
  if (master_ < 0) return {};
  return link_.empty() ? terminal_ : link_;
}

int PtyPeer::baud() const {
  const std::lock_guard lock(mutex_);
  termios settings{};
  if (master_ < 0 || ::tcgetattr(master_, &settings) != 0) return 0;
  switch (::cfgetospeed(&settings)) {
    case B9600:
      return 9600;
    case B38400:
      return 38400;
    case B115200:
      return 115200;
    case B921600:
      return 921600;
    default:
      return 0;
  }
}

void PtyPeer::with_firmware(const std::function<void()>& act) {
  const std::lock_guard lock(mutex_);
  act();
  wake(wake_);
}

void PtyPeer::silence(bool on) {
  const std::lock_guard lock(mutex_);
  silent_ = on;
  if (!on) sends_left_ = SIZE_MAX;
}

void PtyPeer::spoil(std::function<std::string(std::string)> change) {
  const std::lock_guard lock(mutex_);
  spoil_ = std::move(change);
}

void PtyPeer::cut_after(std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  sends_left_ = bytes;
}

void PtyPeer::unplug() {
  const std::lock_guard lock(mutex_);
  close_terminal();
  wake(wake_);
}

void PtyPeer::unplug_after(std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  receives_left_ = bytes;
}

void PtyPeer::plug_in() {
  const std::lock_guard lock(mutex_);
  close_terminal();
  open_terminal();
  receives_left_ = SIZE_MAX;
  wake(wake_);
}

void PtyPeer::open_terminal() {
  char name[128] = "";
  if (::openpty(&master_, &slave_, name, nullptr, nullptr) != 0)
    throw DeviceError(DeviceError::Kind::kFault,
                      std::string("no pseudo-terminal can be had (") + std::strerror(errno) + ")",
                      "mount /dev/pts");
  ::fcntl(master_, F_SETFD, FD_CLOEXEC);
  ::fcntl(slave_, F_SETFD, FD_CLOEXEC);  // kept open, so that the line survives its clients
  ::fcntl(master_, F_SETFL, O_NONBLOCK);
  termios settings{};
  ::tcgetattr(slave_, &settings);
  ::cfmakeraw(&settings);
  ::tcsetattr(slave_, TCSANOW, &settings);
  terminal_ = name;
  if (!link_.empty()) {
    std::error_code ignored;
    fs::remove(link_, ignored);
    fs::create_symlink(terminal_, link_);
  }
}

void PtyPeer::close_terminal() {
  if (master_ < 0) return;
  ::close(std::exchange(slave_, -1));
  ::close(std::exchange(master_, -1));
  unsent_.clear();
  std::error_code ignored;
  if (!link_.empty()) fs::remove(link_, ignored);
}

Nanoseconds PtyPeer::now() const {
  return static_cast<Nanoseconds>(static_cast<double>(SteadyClock().now_ns() - start_ns_) *
                                  time_scale_);
}

void PtyPeer::loop() {
  while (!ending_) {
    pollfd handles[2] = {{wake_, POLLIN, 0}, {-1, 0, 0}};
    timespec wait{3600, 0};
    {
      const std::lock_guard lock(mutex_);
      step();
      handles[1] = {master_, static_cast<short>(POLLIN | (unsent_.empty() ? 0 : POLLOUT)), 0};
      if (const Nanoseconds next = firmware_.next_event(); next != SerialFirmware::kNever) {
        const auto ns = static_cast<Nanoseconds>(
            std::clamp(static_cast<double>(next - now()) / time_scale_, 0.0, 1e12));
        wait = {static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
      }
    }
    ::ppoll(handles, 2, &wait, nullptr);
    std::uint64_t count = 0;
    [[maybe_unused]] const ssize_t n = ::read(wake_, &count, sizeof count);
  }
}

void PtyPeer::step() {
  if (master_ >= 0) {
    char buffer[4096];
    const ssize_t n = ::read(master_, buffer, std::min(sizeof buffer, receives_left_));
    if (n > 0) {
      firmware_.receive({buffer, static_cast<std::size_t>(n)}, now());
      if (receives_left_ != SIZE_MAX) receives_left_ -= static_cast<std::size_t>(n);
    }
    if (receives_left_ == 0) close_terminal();
  }
  std::string sent = firmware_.run(now());
  if (spoil_ && !sent.empty()) sent = spoil_(std::move(sent));
  if (silent_ || master_ < 0) return;
  if (sends_left_ != SIZE_MAX) {
    sent.resize(std::min(sent.size(), sends_left_));
    sends_left_ -= sent.size();
  }
  unsent_ += sent;
  while (!unsent_.empty()) {
    const ssize_t n = ::write(master_, unsent_.data(), unsent_.size());
    if (n <= 0) break;
    unsent_.erase(0, static_cast<std::size_t>(n));
  }
}

}  // namespace wheatstone
