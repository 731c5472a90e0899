#pragma once
// Datagrams that go out (IPv4).

#include <cstdint>
#include <span>
#include <string>

#include "hardware/device_error.h"

namespace wheatstone {

/// Owns a socket connected to one receiver, or to a multicast group.
class UdpSender {
 public:
  /// From this machine's address `from` (empty: as the system's routes say). Throws ArgumentError
  /// for what is no address or port, kNotFound if no route leads there or `from` is not this
  /// machine's, kPermission, kFault.
  UdpSender(const std::string& what, const std::string& address, int port,
            const std::string& from = {});
  ~UdpSender();
  UdpSender(UdpSender&& other) noexcept;
  UdpSender(const UdpSender&) = delete;
  UdpSender& operator=(const UdpSender&) = delete;
  UdpSender& operator=(UdpSender&&) = delete;

  /// Never waits. Returns 0, or the errno of this or an earlier datagram: EAGAIN if there is no
  /// room now, ECONNREFUSED if nobody listens there.
  int send(std::span<const std::uint8_t>) noexcept;
  /// The errno of an earlier datagram, once.
  int take_error() noexcept;

 private:
  int handle_ = -1;
};

}  // namespace wheatstone
