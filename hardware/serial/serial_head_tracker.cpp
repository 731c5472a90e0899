#include "hardware/serial/serial_head_tracker.h"

#include <fmt/format.h>

#include <utility>

namespace wheatstone {
namespace {

constexpr std::size_t kBacklogBytes = 1024, kMostBytes = 1 << 20;
constexpr Nanoseconds kGapNs = 5'000'000;

std::string name(const SerialHeadTrackerSettings& s) {
  if (s.line.empty())
    throw ArgumentError("a head tracker has no address", "name its link in /dev/serial/by-id");
  return "the head tracker at " + s.line.string();
}

}  // namespace

SerialHeadTracker::SerialHeadTracker(const SerialHeadTrackerSettings& settings,
                                     std::shared_ptr<Transcript> transcript)
    : StreamedHeadTracker(name(settings), settings.serial),
      port_(what(), settings.line, settings.baud, std::move(transcript)) {}

DeviceIdentity SerialHeadTracker::identity() const {
  return {"serial head tracker", "", tracker(), "", port_.path().string()};
}

void SerialHeadTracker::fill(const Deadline& deadline) {
  const SteadyClock clock;
  std::size_t before = rest_.size();
  rest_ += port_.read(deadline);
  // So much at once was waiting for us: newer samples may be about to follow.
  while (rest_.size() - before >= kBacklogBytes && rest_.size() < kMostBytes) {
    before = rest_.size();
    try {
      rest_ += port_.read({clock.now_ns() + kGapNs});
    } catch (const DeviceError& e) {
      if (e.kind() != DeviceError::Kind::kTimeout) throw;
    }
  }
}

std::vector<std::string> SerialHeadTracker::lines(const Deadline& deadline) {
  std::vector<std::string> out;
  while (out.empty()) {
    fill(deadline);
    for (std::size_t end; (end = rest_.find('\n')) != std::string::npos;) {
      if (std::exchange(in_step_, true)) out.push_back(rest_.substr(0, end));
      rest_.erase(0, end + 1);
    }
    if (rest_.size() > kLongestHeadSample) {
      const std::string start = std::exchange(rest_, {});
      in_step_ = false;
      throw DeviceError(DeviceError::Kind::kProtocol,
                        fmt::format("{} sends lines without end ({})", what(), hex_of(start)),
                        "check that this is the right device and its speed");
    }
  }
  return out;
}

}  // namespace wheatstone
