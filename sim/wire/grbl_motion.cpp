// How GrblFirmware moves: moves that wait, the one under way, homing.

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/wire/grbl_firmware.h"

namespace wheatstone {
namespace {

double seconds(Nanoseconds ns) {
  return static_cast<double>(ns) * 1e-9;
}
Nanoseconds nanoseconds(double s) {
  return static_cast<Nanoseconds>(s * 1e9);
}

}  // namespace

double GrblFirmware::place(int axis) const {
  return -settings_.at(27) -
         static_cast<double>(steps_at(now_)[static_cast<std::size_t>(axis)]) / steps_per_mm(axis);
}

int GrblFirmware::plan(const std::array<double, kAxes>& target_mm, double feed, Nanoseconds now) {
  Move move;
  move.from = planned_.empty() ? (in_move_ ? move_.to : steps_) : planned_.back().to;
  double longest_s = 0;
  for (int a = 0; a < kAxes; ++a) {
    const auto i = static_cast<std::size_t>(a);
    if (settings_[20] != 0 &&
        (target_mm[i] > 1e-9 || target_mm[i] < -settings_.at(130 + a) - 1e-9)) {
      if (in_move_) halt(now);
      alarm(2, true);
      return -1;
    }
    move.to[i] = std::llround(target_mm[i] * steps_per_mm(a));
    const double distance =
        std::abs(static_cast<double>(move.to[i] - move.from[i])) / steps_per_mm(a);
    const double speed = std::min(feed, settings_.at(110 + a)) / 60, rate = settings_.at(120 + a);
    const double t = distance > speed * speed / rate ? distance / speed + speed / rate
                                                     : 2 * std::sqrt(distance / rate);
    longest_s = std::max(longest_s, t);
  }
  move.duration = nanoseconds(longest_s);
  planned_.push_back(move);
  if (!in_move_ && state_ == State::kIdle) start_next(now);
  return 0;
}

void GrblFirmware::start_next(Nanoseconds now) {
  if (planned_.empty()) {
    if (state_ == State::kRun) state_ = State::kIdle;
    return;
  }
  move_ = planned_.front();
  planned_.pop_front();
  move_.start = now;
  in_move_ = true;
  state_ = State::kRun;
}

std::array<std::int64_t, GrblFirmware::kAxes> GrblFirmware::steps_at(Nanoseconds now) const {
  if (!in_move_) return steps_;
  const double done =
      move_.duration > 0
          ? std::clamp(seconds(now - move_.start) / seconds(move_.duration), 0.0, 1.0)
          : 1;
  std::array<std::int64_t, kAxes> out{};
  for (std::size_t i = 0; i < kAxes; ++i)
    out[i] = move_.from[i] + std::llround(done * static_cast<double>(move_.to[i] - move_.from[i]));
  return out;
}

/// Stands where it is; the rest of the move is planned again.
void GrblFirmware::halt(Nanoseconds now) {
  if (!in_move_) return;
  const Move cut = move_;
  steps_ = steps_at(now);
  in_move_ = false;
  Move remaining = cut;
  remaining.from = steps_;
  remaining.duration = std::max<Nanoseconds>(0, cut.start + cut.duration - now);
  planned_.push_front(remaining);
  rest();
}

void GrblFirmware::rest() {
  for (int a = 0; a < kAxes; ++a) {
    const auto i = static_cast<std::size_t>(a);
    if (std::exchange(rested_at_[i], steps_[i]) == steps_[i] || !machine_.moved) continue;
    machine_.moved(a, -std::llround(settings_.at(27) * steps_per_mm(a)) - steps_[i]);
  }
}

void GrblFirmware::begin_homing(Nanoseconds now) {
  planned_.clear();
  state_ = State::kHoming;
  double s = 0;
  homing_ok_ = true;
  for (int a = 0; a < kAxes; ++a) {
    const auto i = static_cast<std::size_t>(a);
    homing_ok_ = homing_ok_ && options_.switch_works[i];
    const double away =
        homed_ ? -static_cast<double>(steps_[i]) / steps_per_mm(a) : std::abs(options_.start_mm[i]);
    const double search = options_.switch_works[i] ? away : 1.5 * settings_.at(130 + a);
    s = std::max(s,
                 search / (settings_.at(25) / 60) + 2 * settings_.at(27) / (settings_.at(24) / 60));
  }
  homing_until_ = now + nanoseconds(s);
}

void GrblFirmware::end_homing(Nanoseconds) {
  if (!homing_ok_) {
    alarm(9, false);
    out_ += "ok\r\n";
    return;
  }
  for (int a = 0; a < kAxes; ++a) {
    const auto i = static_cast<std::size_t>(a);
    rested_at_[i] = steps_[i] = -std::llround(settings_.at(27) * steps_per_mm(a));
    if (machine_.homed) machine_.homed(a);
  }
  homed_ = true;
  state_ = State::kIdle;
  out_ += "ok\r\n";
}

}  // namespace wheatstone
