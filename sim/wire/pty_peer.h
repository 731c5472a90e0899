#pragma once
// A device at the other end of a pseudo-terminal.

#include <atomic>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "sim/wire/serial_firmware.h"

namespace wheatstone {

/// Runs a firmware in a thread of its own behind a pseudo-terminal that any client can open as it
/// would open a serial line. The firmware's clock starts at 0 and runs `time_scale` times as fast
/// as the machine's. Everything here may be called from any thread.
class PtyPeer {
 public:
  /// `link`: a symbolic link to the terminal, made here, removed at the end. Throws FileError if
  /// there is something else at its place; DeviceError kFault if the system has no terminals.
  explicit PtyPeer(SerialFirmware&, std::filesystem::path link = {}, double time_scale = 1);
  ~PtyPeer();
  PtyPeer(const PtyPeer&) = delete;
  PtyPeer& operator=(const PtyPeer&) = delete;

  /// What a client opens: the link if there is one, else the terminal. Empty while unplugged.
  std::filesystem::path path() const;
  /// The speed that the client has set.
  int baud() const;

  /// Looks at or changes the firmware between two of its steps.
  void with_firmware(const std::function<void()>&);

  // Faults.
  void silence(bool on);                                // what the device sends is lost
  void spoil(std::function<std::string(std::string)>);  // changes all that it sends; empty: no more
  void cut_after(std::size_t bytes);  // sends so many more, then nothing until silence(false)
  void unplug();
  void unplug_after(std::size_t bytes);  // when it has received so many more
  /// Under another path (the link follows); the firmware goes on as it is.
  void plug_in();

 private:
  void open_terminal();
  void close_terminal();
  void loop();
  void step();
  Nanoseconds now() const;

  SerialFirmware& firmware_;
  const std::filesystem::path link_;
  const double time_scale_;
  const Nanoseconds start_ns_ = SteadyClock().now_ns();
  int wake_ = -1;  // eventfd

  mutable std::mutex mutex_;  // of all below and of the firmware
  int master_ = -1, slave_ = -1;
  std::filesystem::path terminal_;
  std::string unsent_;
  bool silent_ = false;
  std::function<std::string(std::string)> spoil_;
  std::size_t sends_left_ = SIZE_MAX, receives_left_ = SIZE_MAX;

  std::atomic<bool> ending_ = false;
  std::thread thread_;
};

}  // namespace wheatstone
