#include "hardware/transport/udp_sender.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

sockaddr_in ipv4(const std::string& text, int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  if (::inet_pton(AF_INET, text.c_str(), &address.sin_addr) != 1)
    throw ArgumentError(fmt::format("'{}' is no IPv4 address", text), "use one like 192.168.0.7");
  return address;
}

}  // namespace

UdpSender::UdpSender(const std::string& what, const std::string& address, int port,
                     const std::string& from) {
  if (port < 1 || port > 65535)
    throw ArgumentError(fmt::format("{} is no UDP port", port), "use 1 to 65535");
  const sockaddr_in to = ipv4(address, port);
  const sockaddr_in here = ipv4(from.empty() ? "0.0.0.0" : from, 0);
  handle_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (!from.empty())  // of multicast, which bind() does not direct
    ::setsockopt(handle_, IPPROTO_IP, IP_MULTICAST_IF, &here.sin_addr, sizeof here.sin_addr);
  if (handle_ >= 0 && ::bind(handle_, reinterpret_cast<const sockaddr*>(&here), sizeof here) == 0 &&
      ::connect(handle_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0)
    return;
  const int error = errno;
  if (handle_ >= 0) ::close(handle_);
  const std::string problem =
      fmt::format("{} cannot be reached at {}:{} ({})", what, address, port, std::strerror(error));
  if (error == ENETUNREACH || error == EHOSTUNREACH || error == EADDRNOTAVAIL)
    throw DeviceError(Kind::kNotFound, problem, "connect the network, and correct the addresses");
  if (error == EACCES || error == EPERM)
    throw DeviceError(Kind::kPermission, problem, "use the address of one receiver");
  throw DeviceError(Kind::kFault, problem, "check the network");
}

UdpSender::UdpSender(UdpSender&& other) noexcept : handle_(std::exchange(other.handle_, -1)) {}

UdpSender::~UdpSender() {
  if (handle_ >= 0) ::close(handle_);
}

int UdpSender::send(std::span<const std::uint8_t> bytes) noexcept {
  return ::send(handle_, bytes.data(), bytes.size(), MSG_NOSIGNAL) < 0 ? errno : 0;
}

int UdpSender::take_error() noexcept {
  int error = 0;
  socklen_t size = sizeof error;
  ::getsockopt(handle_, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

}  // namespace wheatstone
