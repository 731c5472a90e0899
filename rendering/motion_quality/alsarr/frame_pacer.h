#pragma once
// Holds a chosen refresh rate by letting frames wait, for displays whose refresh follows the frames
// (adaptive synchronisation), and keeps a record of what was achieved.

#include "core/clock.h"

namespace wheatstone {

struct PacedFrame {
  Nanoseconds due_ns = 0;      // when the frame was to start
  Nanoseconds started_ns = 0;  // when it did, at or after due_ns
  Duration interval;           // since the start of the frame before; 0 for the first
  bool late = false;           // the work of the frame before took longer than the interval
};

/// Intervals are of frames 2, 3, ...; 0 before the second.
struct PacingReport {
  int frames = 0, late = 0;
  double mean_interval_s = 0, shortest_interval_s = 0, longest_interval_s = 0;
  double achieved_refresh_hz() const { return mean_interval_s > 0 ? 1 / mean_interval_s : 0; }
};

/// Threads: one at a time. Frames are due one interval apart from the first on, so that waiting
/// too long once does not add up; after a late frame the count starts anew from it, because
/// hurrying after lost frames would show as judder.
class FramePacer {
 public:
  /// The clock must outlive it. Errors: ArgumentError unless refresh_hz is in 1..1000.
  FramePacer(Clock&, double refresh_hz);

  /// From the next frame on. Errors: as above.
  void set_refresh_hz(double refresh_hz);

  /// Waits until the next frame may start (not at all for the first, or when late).
  PacedFrame next_frame();

  /// Over all frames so far.
  PacingReport report() const { return report_; }

 private:
  Clock& clock_;
  Nanoseconds interval_ns_ = 0;
  Nanoseconds due_ns_ = 0, started_ns_ = 0;  // of the last frame
  PacingReport report_;
};

}  // namespace wheatstone
