#include "sim/wire/udp_peer.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "hardware/device_error.h"

namespace wheatstone {
namespace {

constexpr Nanoseconds kLongestNapNs = 10'000'000;  // changes of the firmware are seen within it

}  // namespace

UdpPeer::UdpPeer(SerialFirmware& firmware, int port)
    : firmware_(firmware),
      port_(port),
      handle_(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  if (handle_ < 0)
    throw DeviceError(DeviceError::Kind::kFault, "no UDP socket can be had", "check the network");
  thread_ = std::jthread([this](const std::stop_token& stop) { loop(stop); });
}

UdpPeer::~UdpPeer() {
  thread_.request_stop();
  thread_.join();
  ::close(handle_);
}

void UdpPeer::with_firmware(const std::function<void()>& act) {
  const std::lock_guard lock(mutex_);
  act();
}

void UdpPeer::spoil(std::function<std::string(std::string)> change) {
  const std::lock_guard lock(mutex_);
  spoil_ = std::move(change);
}

void UdpPeer::send(const std::string& datagram) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port_));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  [[maybe_unused]] const ssize_t n = ::sendto(handle_, datagram.data(), datagram.size(), 0,
                                              reinterpret_cast<sockaddr*>(&to), sizeof to);
}

void UdpPeer::loop(const std::stop_token& stop) {
  SteadyClock clock;
  while (!stop.stop_requested()) {
    Nanoseconds next = 0;
    {
      const std::lock_guard lock(mutex_);
      std::string lines = firmware_.run(clock.now_ns() - start_ns_);
      for (std::size_t end; (end = lines.find('\n')) != std::string::npos;) {
        std::string line = lines.substr(0, end);
        lines.erase(0, end + 1);
        if (spoil_) line = spoil_(std::move(line));
        if (!silent_) send(line);
      }
      next = firmware_.next_event();
    }
    const Nanoseconds now = clock.now_ns();
    clock.wait_until(
        std::min(next == SerialFirmware::kNever ? next : next + start_ns_, now + kLongestNapNs));
  }
}

}  // namespace wheatstone
