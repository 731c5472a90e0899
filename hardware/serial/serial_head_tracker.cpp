#include "hardware/serial/serial_head_tracker.h"

#include <fmt/format.h>

#include <utility>

namespace wheatstone {
namespace {

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

std::vector<std::string> SerialHeadTracker::lines(const Deadline& deadline) {
  std::vector<std::string> out;
  while (out.empty()) {
    rest_ += port_.read(deadline);
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
