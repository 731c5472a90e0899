#include "hardware/hid/hid_device.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <hidapi.h>
#include <poll.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "core/error.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr Duration kPatience = Duration::of(0.1);  // of send_now()
constexpr const char* kPlugIn = "plug it in again, then run the command again";

/// hidapi keeps the text of its last error in a global variable.
std::mutex& hidapi_mutex() {
  static std::mutex mutex;
  return mutex;
}

std::string narrow(const wchar_t* text) {
  std::string out;
  for (; text && *text; ++text)
    out += *text >= 0x20 && *text < 0x7f ? static_cast<char>(*text) : '?';
  return out;
}

bool means_gone(int error) {
  return error == ENODEV || error == ENXIO || error == ESHUTDOWN;
}

[[noreturn]] void refuse_to_open(const std::string& what, int error) {
  const std::string problem = fmt::format("{} cannot be opened ({})", what, std::strerror(error));
  if (error == ENOENT || error == ENOTDIR || means_gone(error))
    throw DeviceError(Kind::kNotFound, what + " is not there",
                      "plug it in, or correct its address in the rig file");
  if (error == EACCES || error == EPERM)
    throw DeviceError(Kind::kPermission, problem,
                      "install the udev rules of wheatstone (udev/60-wheatstone.rules), join the "
                      "group plugdev and plug it in again");
  if (error == EBUSY || error == EWOULDBLOCK)
    throw DeviceError(Kind::kBusy, what + " is in use by another program", "end that program");
  throw DeviceError(Kind::kFault, problem, "unplug it and plug it in again");
}

bool hung_up(int handle) {
  pollfd state{handle, 0, 0};
  return ::poll(&state, 1, 0) > 0 && (state.revents & (POLLHUP | POLLERR)) != 0;
}

std::chrono::steady_clock::time_point at(Nanoseconds ns) {
  return std::chrono::steady_clock::time_point(std::chrono::nanoseconds(ns));
}

}  // namespace

std::vector<HidFound> list_hid_devices(std::uint16_t vendor, std::uint16_t product) {
  const std::lock_guard lock(hidapi_mutex());
  const std::unique_ptr<hid_device_info, void (*)(hid_device_info*)> list(
      ::hid_enumerate(vendor, product), ::hid_free_enumeration);
  std::vector<HidFound> out;
  for (const hid_device_info* d = list.get(); d; d = d->next)
    if (d->path && *d->path)  // empty: it went away meanwhile
      out.push_back({d->path, narrow(d->product_string), narrow(d->serial_number)});
  const auto order = [](const HidFound& d) {
    return std::pair(d.node.native().size(), d.node.native());
  };
  std::sort(out.begin(), out.end(),
            [&](const auto& a, const auto& b) { return order(a) < order(b); });
  return out;
}

HidDevice::HidDevice(const std::string& what, const std::filesystem::path& node, Use use,
                     std::shared_ptr<Transcript> transcript)
    : what_(what),
      node_(node),
      transcript_(transcript ? std::move(transcript) : std::make_shared<Transcript>()) {
  lock_ = ::open(node.c_str(), O_RDWR | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (lock_ < 0) refuse_to_open(what_, errno);
  int error = use == Use::kOwn && ::flock(lock_, LOCK_EX | LOCK_NB) != 0 ? errno : 0;
  if (error == 0) {
    const std::lock_guard lock(hidapi_mutex());
    errno = 0;
    device_ = ::hid_open_path(node.c_str());
    if (!device_) error = errno ? errno : EIO;
  }
  if (!device_) {
    ::close(lock_);
    refuse_to_open(what_, error);
  }
  thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
}

HidDevice::~HidDevice() {
  thread_.request_stop();
  thread_.join();
  ::hid_close(device_);
  ::close(lock_);
}

bool HidDevice::owned() const {
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0) return true;
  ::flock(lock_, LOCK_UN);
  return false;
}

void HidDevice::work(const std::stop_token& stop) {
  bool silent = false;
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return !waiting_.empty(); }) || !waiting_.empty()) {
    const std::shared_ptr<Transfer> transfer = waiting_.front();
    waiting_.pop_front();
    if (lost_) {
      transfer->error = ENODEV;
    } else if (stop.stop_requested() && silent) {
      transfer->error = ETIMEDOUT;  // the destructor waits
    } else {
      lock.unlock();
      carry_out(*transfer);
      lock.lock();
    }
    lost_ = lost_ || means_gone(transfer->error);
    silent = transfer->error == ETIMEDOUT;
    transfer->done = true;
    changed_.notify_all();
  }
}

void HidDevice::carry_out(Transfer& t) {
  auto* bytes = reinterpret_cast<unsigned char*>(t.bytes.data());
  if (!t.get) transcript_->to_device(t.bytes);
  errno = 0;
  const int n = t.get ? ::hid_get_feature_report(device_, bytes, t.bytes.size())
                      : ::hid_send_feature_report(device_, bytes, t.bytes.size());
  if (n < 0) {
    t.error = errno ? errno : EIO;
    // A cable that is pulled shows as a failed transfer first.
    if (hung_up(lock_)) t.error = ENODEV;
  } else if (t.get) {
    t.bytes.resize(std::min(t.bytes.size(), static_cast<std::size_t>(n)));
    transcript_->to_host(t.bytes);
  }
}

std::string HidDevice::perform(const std::shared_ptr<Transfer>& transfer,
                               const Deadline& deadline) {
  check(deadline);
  std::unique_lock lock(mutex_);
  if (!transfer->get && !sends_allowed_)
    throw DeviceError(Kind::kRefused, what_ + " was switched off meanwhile",
                      "run the command again");
  waiting_.push_back(transfer);
  changed_.notify_all();
  if (!changed_.wait_until(lock, deadline.cancel, at(deadline.at_ns),
                           [&] { return transfer->done; })) {
    std::erase(waiting_, transfer);
    if (deadline.cancel.stop_requested()) throw Cancelled(what_ + ": stopped on request");
    time_out();
  }
  if (transfer->error) {
    lock.unlock();
    fail(transfer->error);
  }
  return std::move(transfer->bytes);
}

void HidDevice::send_feature(std::string_view report, const Deadline& deadline) {
  perform(std::make_shared<Transfer>(Transfer{std::string(report)}), deadline);
}

std::string HidDevice::get_feature(std::uint8_t number, std::size_t longest,
                                   const Deadline& deadline) {
  std::string buffer(longest, '\0');
  buffer.at(0) = static_cast<char>(number);
  return perform(std::make_shared<Transfer>(Transfer{std::move(buffer), true}), deadline);
}

void HidDevice::send_now(std::string_view report) noexcept {
  const auto transfer = std::make_shared<Transfer>(Transfer{std::string(report)});
  std::unique_lock lock(mutex_);
  sends_allowed_ = false;
  std::erase_if(waiting_, [](const auto& t) {
    if (!t->get) t->error = ECANCELED;
    return !t->get && (t->done = true);
  });
  waiting_.push_front(transfer);
  changed_.notify_all();
  changed_.wait_until(lock, at(SteadyClock().in(kPatience).at_ns), [&] { return transfer->done; });
}

bool HidDevice::allow_sends() {
  const std::lock_guard lock(mutex_);
  return std::exchange(sends_allowed_, true);
}

bool HidDevice::sends_allowed() const {
  const std::lock_guard lock(mutex_);
  return sends_allowed_;
}

void HidDevice::check(const Deadline& deadline) const {
  if (const std::lock_guard lock(mutex_); lost_)
    throw DeviceError(Kind::kDisconnected, what_ + " was disconnected", kPlugIn);
  if (deadline.cancel.stop_requested()) throw Cancelled(what_ + ": stopped on request");
  if (SteadyClock().now_ns() >= deadline.at_ns) time_out();
}

void HidDevice::time_out() const {
  throw DeviceError(Kind::kTimeout, what_ + " did not answer in time",
                    "unplug it and plug it in again, then run the command again");
}

void HidDevice::fail(int error) {
  if (means_gone(error))
    throw DeviceError(Kind::kDisconnected,
                      fmt::format("{} is disconnected ({})", what_, std::strerror(error)), kPlugIn);
  if (error == ETIMEDOUT) time_out();
  if (error == ECANCELED)
    throw DeviceError(Kind::kRefused, what_ + " was switched off meanwhile",
                      "run the command again");
  if (error == EPIPE)
    throw DeviceError(Kind::kRefused, what_ + " refuses a report",
                      "check that it is the kind of device that the rig file says");
  throw DeviceError(Kind::kFault,
                    fmt::format("a transfer to {} failed ({})", what_, std::strerror(error)),
                    "try another cable or port, without a hub");
}

}  // namespace wheatstone
