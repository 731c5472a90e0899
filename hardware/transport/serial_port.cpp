#include "hardware/transport/serial_port.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr Nanoseconds kStopCheckNs = 40'000'000;

speed_t speed_of(int baud) {
  constexpr std::pair<int, speed_t> kSpeeds[] = {
      {9600, B9600},     {19200, B19200},   {38400, B38400},   {57600, B57600},
      {115200, B115200}, {230400, B230400}, {460800, B460800}, {921600, B921600}};
  for (const auto& [number, code] : kSpeeds)
    if (number == baud) return code;
  throw ArgumentError(fmt::format("a serial line cannot run at {} baud", baud),
                      "use 9600, 19200, 38400, 57600, 115200, 230400, 460800 or 921600");
}

int open_line(const std::string& what, const std::filesystem::path& path) {
  const int handle = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (handle >= 0) return handle;
  const std::string reason = std::strerror(errno);
  switch (errno) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
    case ENOTDIR:
      throw DeviceError(Kind::kNotFound, fmt::format("{} is not there", what),
                        "plug it in and switch it on, or correct its address in the rig file");
    case EACCES:
    case EPERM:
      throw DeviceError(Kind::kPermission, fmt::format("{} may not be opened ({})", what, reason),
                        "install the udev rules (cmake --install) and join the group plugdev");
    case EBUSY:
      throw DeviceError(Kind::kBusy, fmt::format("{} is in use by another program", what),
                        "end the other program");
    default:
      throw DeviceError(Kind::kFault, fmt::format("{} cannot be opened ({})", what, reason),
                        "unplug it and plug it in again");
  }
}

}  // namespace

SerialPort::SerialPort(const std::string& what, const std::filesystem::path& path, int baud,
                       std::shared_ptr<Transcript> transcript)
    : what_(what),
      path_(path),
      transcript_(transcript ? std::move(transcript) : std::make_shared<Transcript>()) {
  const speed_t speed = speed_of(baud);
  handle_ = open_line(what, path);
  const auto fail = [&](Kind kind, const std::string& problem, const std::string& remedy) {
    ::close(handle_);
    throw DeviceError(kind, what_ + " " + problem, remedy);
  };
  // TIOCEXCL does not stop root, a lock stops only those who ask: both together suffice.
  if (::flock(handle_, LOCK_EX | LOCK_NB) != 0)
    fail(Kind::kBusy, "is in use by another program", "end the other program");
  termios settings{};
  if (::tcgetattr(handle_, &settings) != 0)
    fail(Kind::kFault, "is no serial line", "correct its address in the rig file");
  ::ioctl(handle_, TIOCEXCL);
  ::cfmakeraw(&settings);
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS | HUPCL);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 0;
  ::cfsetspeed(&settings, speed);
  if (::tcsetattr(handle_, TCSANOW, &settings) != 0)
    fail(Kind::kFault, fmt::format("cannot be set to {} baud", baud), "check the adapter");
  ::tcflush(handle_, TCIOFLUSH);
}

SerialPort::~SerialPort() {
  ::ioctl(handle_, TIOCNXCL);
  ::close(handle_);
}

void SerialPort::lost(const std::string& how) {
  lost_ = true;
  throw DeviceError(Kind::kDisconnected, what_ + " is disconnected (" + how + ")",
                    "plug it in again, then run the command again");
}

void SerialPort::require_connected() const {
  if (lost_)
    throw DeviceError(Kind::kDisconnected, what_ + " was disconnected",
                      "plug it in again, then run the command again");
}

bool SerialPort::wait_for(short events, const Deadline& deadline) {
  const SteadyClock clock;
  for (;;) {
    if (deadline.cancel.stop_requested()) throw Cancelled(what_ + ": stopped on request");
    const Nanoseconds left = deadline.at_ns - clock.now_ns();
    const Nanoseconds slice = std::clamp<Nanoseconds>(left, 0, kStopCheckNs);
    const timespec wait{0, static_cast<long>(slice)};
    pollfd line{handle_, events, 0};
    const int ready = ::ppoll(&line, 1, &wait, nullptr);
    if (ready < 0 && errno != EINTR) lost(std::strerror(errno));
    if (ready > 0) {
      if (line.revents & events) return true;  // what came before a hang-up is read first
      lost("hung up");
    }
    if (left <= 0) return false;
  }
}

void SerialPort::time_out() const {
  throw DeviceError(Kind::kTimeout, what_ + " did not answer in time",
                    "check cable and power, then run the command again");
}

void SerialPort::write(std::string_view bytes, const Deadline& deadline) {
  require_connected();
  transcript_->to_device(bytes);
  while (!bytes.empty()) {
    if (!wait_for(POLLOUT, deadline)) time_out();
    const ssize_t n = ::write(handle_, bytes.data(), bytes.size());
    if (n < 0 && errno != EAGAIN && errno != EINTR) lost(std::strerror(errno));
    if (n > 0) bytes.remove_prefix(static_cast<std::size_t>(n));
  }
}

void SerialPort::write_now(std::string_view bytes) noexcept {
  [[maybe_unused]] const ssize_t n = ::write(handle_, bytes.data(), bytes.size());
}

bool SerialPort::fill(const Deadline& deadline) {
  require_connected();
  if (!wait_for(POLLIN, deadline)) return false;
  char buffer[4096];
  const ssize_t n = ::read(handle_, buffer, sizeof buffer);
  if (n == 0) lost("end of file");
  if (n < 0 && errno != EAGAIN && errno != EINTR) lost(std::strerror(errno));
  if (n > 0) {
    transcript_->to_host({buffer, static_cast<std::size_t>(n)});
    input_.append(buffer, static_cast<std::size_t>(n));
  }
  return true;
}

std::string SerialPort::read(const Deadline& deadline) {
  while (input_.empty())
    if (!fill(deadline)) time_out();
  return std::exchange(input_, {});
}

std::string SerialPort::read_line(char end, std::size_t longest, const Deadline& deadline) {
  std::optional<std::string> line = try_read_line(end, longest, deadline);
  if (!line) time_out();
  return *std::move(line);
}

std::optional<std::string> SerialPort::try_read_line(char end, std::size_t longest,
                                                     const Deadline& deadline) {
  for (;;) {
    const std::size_t at = input_.find(end);
    if (at != std::string::npos && at <= longest) {
      std::string line = input_.substr(0, at);
      input_.erase(0, at + 1);
      return line;
    }
    if (input_.size() > longest) {
      const std::string start = std::exchange(input_, {});
      throw DeviceError(Kind::kProtocol,
                        fmt::format("{} sends lines without end ({})", what_, hex_of(start)),
                        "check that this is the right device and its speed");
    }
    if (!fill(deadline)) return std::nullopt;
  }
}

void SerialPort::discard_input() {
  const SteadyClock clock;
  while (fill({clock.now_ns()})) input_.clear();
  input_.clear();
}

}  // namespace wheatstone
