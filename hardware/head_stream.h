#pragma once
// Head trackers that send their samples unasked, one line of JSON each (docs/hardware/
// head_tracker.md), over whatever carries lines.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hardware/head_tracker.h"

namespace wheatstone {

/// One sample as it is sent. Times are microseconds on the tracker's own clock.
struct HeadSample {
  std::string tracker;       // its serial
  std::uint32_t number = 0;  // one more each sample, wraps
  std::int64_t exposed_us = 0, sent_us = 0;
  std::array<std::optional<EyeCentre>, 2> eyes;  // left, right
};

inline constexpr std::size_t kLongestHeadSample = 2048;  // bytes

/// Throws DeviceError kProtocol, quoting the line, for anything but a sample: positions farther
/// than 10 m, a covariance that is none, a confidence outside 0..1, sent before exposed.
/// `what` names the tracker in errors.
HeadSample parse_head_sample(const std::string& what, std::string_view line);
/// Without the end of line.
std::string to_line(const HeadSample&);

/// The machine's time of samples, from when they were read: the least delay seen so far counts as
/// none. The clocks may drift apart by kDriftPpm.
class TrackerClock {
 public:
  static constexpr double kDriftPpm = 200;

  Nanoseconds exposed_ns(const HeadSample&, Nanoseconds read_ns);
  /// The tracker, or its clock, started anew.
  void forget() { offset_ns_.reset(); }

 private:
  std::optional<Nanoseconds> offset_ns_;  // machine's clock minus tracker's
  Nanoseconds last_read_ns_ = 0;
};

class StreamedHeadTracker : public HeadTracker {
 public:
  /// Samples that are late (numbered before one that came already) are skipped. Bad ones throw
  /// kProtocol, ones from another tracker kFault, unless a good and newer one has come too.
  EyeCentres next(Deadline) final;

 protected:
  /// `serial`: of the only tracker to listen to; empty: any.
  StreamedHeadTracker(std::string what, std::string serial)
      : what_(std::move(what)), serial_(std::move(serial)) {}
  /// All that came and was not read, at least one.
  virtual std::vector<std::string> lines(const Deadline&) = 0;
  /// As the last sample had it.
  const std::string& tracker() const { return tracker_; }
  const std::string& what() const { return what_; }

 private:
  void take(const HeadSample&, Nanoseconds read_ns);

  std::string what_, serial_, tracker_;
  TrackerClock clock_;
  bool any_ = false;
  std::uint32_t number_ = 0;     // of the newest sample
  std::int64_t exposed_us_ = 0;  // of the same
  std::optional<EyeCentres> newest_;
};

}  // namespace wheatstone
