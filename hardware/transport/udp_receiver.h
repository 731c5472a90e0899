#pragma once
// Datagrams that come in (IPv4).

#include <memory>
#include <string>
#include <vector>

#include "core/clock.h"
#include "hardware/device_error.h"
#include "hardware/transport/transcript.h"

namespace wheatstone {

/// Owns a bound socket. Errors of receive(): DeviceError kTimeout, Cancelled (within 50 ms).
class UdpReceiver {
 public:
  /// Listens at `address` ("0.0.0.0": all of this machine's) and `port` (0: any free one); only to
  /// `from` if it is not empty. Throws ArgumentError for what is no address or port, kBusy if
  /// somebody listens there already, kNotFound for an address that is not this machine's,
  /// kPermission.
  UdpReceiver(const std::string& what, const std::string& address, int port,
              const std::string& from = {}, std::shared_ptr<Transcript> = nullptr);
  ~UdpReceiver();
  UdpReceiver(const UdpReceiver&) = delete;
  UdpReceiver& operator=(const UdpReceiver&) = delete;

  int port() const { return port_; }
  /// All that came, at least one, at most 1000; each cut to `longest` + 1 bytes.
  std::vector<std::string> receive(std::size_t longest, const Deadline&);

 private:
  std::string what_;
  std::shared_ptr<Transcript> transcript_;
  std::uint32_t from_ = 0;  // network order; 0: any
  int handle_ = -1, port_ = 0;
};

}  // namespace wheatstone
