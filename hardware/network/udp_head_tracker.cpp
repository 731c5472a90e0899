#include "hardware/network/udp_head_tracker.h"

#include <fmt/format.h>

#include <utility>

namespace wheatstone {

UdpHeadTracker::UdpHeadTracker(const UdpHeadTrackerSettings& s,
                               std::shared_ptr<Transcript> transcript)
    : StreamedHeadTracker(fmt::format("the head tracker on UDP {}:{}", s.address, s.port),
                          s.serial),
      receiver_(what(), s.address, s.port, s.from, std::move(transcript)) {}

DeviceIdentity UdpHeadTracker::identity() const {
  return {"UDP head tracker", "", tracker(), "", fmt::format("udp port {}", receiver_.port())};
}

std::vector<std::string> UdpHeadTracker::lines(const Deadline& deadline) {
  return receiver_.receive(kLongestHeadSample, deadline);
}

}  // namespace wheatstone
