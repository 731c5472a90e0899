#pragma once
// A serial line in raw mode, 8N1, no flow control (POSIX termios).

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/clock.h"
#include "hardware/device_error.h"
#include "hardware/transport/transcript.h"

namespace wheatstone {

/// Owns the line from construction to destruction; nobody else can open it in between (TIOCEXCL and
/// an advisory lock). Deadlines are on the machine's monotonic clock (SteadyClock), exact to a few
/// milliseconds; a request to stop is seen within 50 ms. No call keeps a core busy while it waits.
/// One thread at a time, but for write_now().
/// Errors of all calls: DeviceError kTimeout, kDisconnected (sticky), Cancelled.
class SerialPort {
 public:
  /// `what` names the device in errors ("the stage on /dev/ttyACM0"). Throws ArgumentError for a
  /// speed that termios does not know; kNotFound, kPermission, kBusy, kFault as the system says.
  SerialPort(const std::string& what, const std::filesystem::path&, int baud,
             std::shared_ptr<Transcript> = nullptr);
  ~SerialPort();
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  const std::string& what() const { return what_; }
  const std::filesystem::path& path() const { return path_; }

  void write(std::string_view, const Deadline&);
  /// Real-time bytes, from any thread; given up if the line does not take them at once.
  void write_now(std::string_view) noexcept;
  /// All that has come, at least one byte.
  std::string read(const Deadline&);
  /// Up to the next `end`, which is not part of the result. Throws kProtocol when `longest` bytes
  /// come without one; they are dropped.
  std::string read_line(char end, std::size_t longest, const Deadline&);
  /// The same, but nothing instead of kTimeout.
  std::optional<std::string> try_read_line(char end, std::size_t longest, const Deadline&);
  /// What has come so far and was not read.
  void discard_input();

 private:
  [[noreturn]] void lost(const std::string& how);
  void require_connected() const;
  bool fill(const Deadline&);  // false: nothing came in time
  bool wait_for(short events, const Deadline&);
  [[noreturn]] void time_out() const;

  std::string what_;
  std::filesystem::path path_;
  std::shared_ptr<Transcript> transcript_;
  int handle_ = -1;
  bool lost_ = false;
  std::string input_;
};

}  // namespace wheatstone
