#include "rendering/motion_quality/alsarr/frame_pacer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace wheatstone {

FramePacer::FramePacer(Clock& clock, double refresh_hz) : clock_(clock) {
  set_refresh_hz(refresh_hz);
}

void FramePacer::set_refresh_hz(double refresh_hz) {
  if (!(refresh_hz >= 1 && refresh_hz <= 1000))
    throw ArgumentError(fmt::format("a refresh rate of {} Hz cannot be held", refresh_hz),
                        "give 1 to 1000 Hz");
  interval_ns_ = std::llround(1e9 / refresh_hz);
}

PacedFrame FramePacer::next_frame() {
  const bool first = report_.frames == 0;
  const Nanoseconds ready_ns = clock_.now_ns();
  PacedFrame frame;
  frame.due_ns = first ? ready_ns : due_ns_ + interval_ns_;
  frame.late = ready_ns > frame.due_ns;
  if (!first && !frame.late) clock_.wait_until(frame.due_ns);
  frame.started_ns = clock_.now_ns();
  due_ns_ = frame.late ? frame.started_ns : frame.due_ns;

  ++report_.frames;
  report_.late += frame.late;
  if (!first) {
    const double interval_s = static_cast<double>(frame.started_ns - started_ns_) * 1e-9;
    frame.interval = Duration::of(interval_s);
    const int intervals = report_.frames - 1;
    report_.mean_interval_s += (interval_s - report_.mean_interval_s) / intervals;
    report_.shortest_interval_s =
        intervals == 1 ? interval_s : std::min(report_.shortest_interval_s, interval_s);
    report_.longest_interval_s = std::max(report_.longest_interval_s, interval_s);
  }
  started_ns_ = frame.started_ns;
  return frame;
}

}  // namespace wheatstone
