#include "hardware/transport/udp_receiver.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr Nanoseconds kStopCheckNs = 40'000'000;
constexpr std::size_t kMostAtOnce = 1000;

std::uint32_t ipv4(const std::string& text) {
  in_addr address{};
  if (::inet_pton(AF_INET, text.c_str(), &address) != 1)
    throw ArgumentError(fmt::format("'{}' is no IPv4 address", text), "use one like 192.168.0.7");
  return address.s_addr;
}

}  // namespace

UdpReceiver::UdpReceiver(const std::string& what, const std::string& address, int port,
                         const std::string& from, std::shared_ptr<Transcript> transcript)
    : what_(what),
      transcript_(transcript ? std::move(transcript) : std::make_shared<Transcript>()),
      from_(from.empty() ? 0 : ipv4(from)) {
  if (port < 0 || port > 65535)
    throw ArgumentError(fmt::format("{} is no UDP port", port), "use 1024 to 65535");
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_port = htons(static_cast<std::uint16_t>(port));
  here.sin_addr.s_addr = ipv4(address);
  handle_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (handle_ < 0 || ::bind(handle_, reinterpret_cast<sockaddr*>(&here), sizeof here) != 0) {
    const int error = errno;
    if (handle_ >= 0) ::close(handle_);
    const std::string problem =
        fmt::format("{} cannot listen at {}:{} ({})", what_, address, port, std::strerror(error));
    if (error == EADDRINUSE)
      throw DeviceError(Kind::kBusy, problem, "end the other program, or use another port");
    if (error == EADDRNOTAVAIL)
      throw DeviceError(Kind::kNotFound, problem, "use an address of this machine");
    if (error == EACCES || error == EPERM)
      throw DeviceError(Kind::kPermission, problem, "use a port above 1023");
    throw DeviceError(Kind::kFault, problem, "check the network");
  }
  socklen_t size = sizeof here;
  ::getsockname(handle_, reinterpret_cast<sockaddr*>(&here), &size);
  port_ = ntohs(here.sin_port);
}

UdpReceiver::~UdpReceiver() {
  ::close(handle_);
}

std::vector<std::string> UdpReceiver::receive(std::size_t longest, const Deadline& deadline) {
  const SteadyClock clock;
  std::vector<std::string> out;
  for (;;) {
    std::string bytes(longest + 1, '\0');
    sockaddr_in sender{};
    socklen_t size = sizeof sender;
    const ssize_t n = ::recvfrom(handle_, bytes.data(), bytes.size(), 0,
                                 reinterpret_cast<sockaddr*>(&sender), &size);
    if (n >= 0 && (!from_ || sender.sin_addr.s_addr == from_)) {
      bytes.resize(static_cast<std::size_t>(n));
      transcript_->to_host(bytes);
      out.push_back(std::move(bytes));
      if (out.size() < kMostAtOnce) continue;
    }
    if (!out.empty()) return out;
    if (deadline.cancel.stop_requested()) throw Cancelled(what_ + ": stopped on request");
    const Nanoseconds left = deadline.at_ns - clock.now_ns();
    if (left <= 0)
      throw DeviceError(Kind::kTimeout, what_ + " sends nothing",
                        "check that it runs, and to which address and port it sends");
    const timespec slice{0, static_cast<long>(std::min(left, kStopCheckNs))};
    pollfd socket{handle_, POLLIN, 0};
    ::ppoll(&socket, 1, &slice, nullptr);
  }
}

}  // namespace wheatstone
