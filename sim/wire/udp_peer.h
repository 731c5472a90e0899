#pragma once
// A device that sends datagrams.

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "sim/wire/serial_firmware.h"

namespace wheatstone {

/// Runs a firmware in a thread of its own and sends each line that it gives as a datagram to a port
/// of this machine. The firmware's clock starts at 0. Everything here may be called from any
/// thread.
class UdpPeer {
 public:
  /// Throws DeviceError kFault if the system has no sockets.
  UdpPeer(SerialFirmware&, int port);
  ~UdpPeer();
  UdpPeer(const UdpPeer&) = delete;
  UdpPeer& operator=(const UdpPeer&) = delete;

  /// Looks at or changes the firmware between two of its steps.
  void with_firmware(const std::function<void()>&);
  void send(const std::string& datagram);

  // Faults.
  void silence(bool on) { silent_ = on; }
  void spoil(std::function<std::string(std::string)>);  // changes every line; empty: no more

 private:
  void loop(const std::stop_token&);

  SerialFirmware& firmware_;
  const int port_;
  const Nanoseconds start_ns_ = SteadyClock().now_ns();
  int handle_ = -1;
  std::atomic<bool> silent_ = false;
  std::mutex mutex_;  // of the firmware and of spoil_
  std::function<std::string(std::string)> spoil_;
  std::jthread thread_;
};

}  // namespace wheatstone
