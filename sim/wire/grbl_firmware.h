#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>

#include "sim/wire/serial_firmware.h"

namespace wheatstone {

/// A GRBL 1.1h controller with homing switches at the positive ends of X (the rail, mm) and Y (the
/// turning platform, degrees). Protocol: reference gantry_and_rotary.md, section 2. Knows the
/// commands that a positioning machine needs: G0 G1 G4 G20 G21 G53 G54 G90 G91 G94 G10 L2, M2 M5 M9
/// M30, F S T N, $ $$ $# $G $I $N $n= $H $X $C $J=; others are answered as GRBL does what it was
/// not built for (error:20). Positions are whole steps.
class GrblFirmware final : public SerialFirmware {
 public:
  static constexpr int kAxes = 2;
  struct Options {
    std::string version = "1.1h";
    std::array<double, kAxes> start_mm = {40, 30};  // from the switch, before homing
    std::array<bool, kAxes> switch_works = {true, true};
  };
  /// What it moves. Called when an axis has come to rest at another place.
  struct Machine {
    std::function<void(int axis)> homed;
    std::function<void(int axis, std::int64_t steps)> moved;  // away from where homing ends
  };

  GrblFirmware() : GrblFirmware(Options{}, {}) {}
  GrblFirmware(Options, Machine);

  void receive(std::string_view, Nanoseconds now) override;
  std::string run(Nanoseconds now) override;
  Nanoseconds next_event() const override;

  // What a test may look at and do.
  bool moving() const { return state_ == State::kRun || state_ == State::kHoming; }
  bool homed() const { return homed_; }
  /// Away from where homing ends, in the axis's unit; unlike the controller, this is always true.
  double place(int axis) const;
  double setting(int number) const { return settings_.at(number); }
  void set(int number, double value) { settings_[number] = value; }
  /// Hits a limit switch: alarm 1.
  void hit_limit() { hit_limit_ = true; }
  /// Loses its power for a moment.
  void restart();

 private:
  enum class State { kIdle, kRun, kHold, kAlarm, kHoming };
  struct Move {
    std::array<std::int64_t, kAxes> from{}, to{};
    Nanoseconds start = 0, duration = 0;
  };

  void reset(Nanoseconds now, bool power_up);
  void real_time(char, Nanoseconds now);
  void advance(Nanoseconds now);
  void finish_line(Nanoseconds now);
  void execute(const std::string& line, Nanoseconds now);
  void system_command(const std::string& line, Nanoseconds now);
  int gcode(const std::string& line, Nanoseconds now);
  int plan(const std::array<double, kAxes>& target_mm, double feed, Nanoseconds now);
  void start_next(Nanoseconds now);
  void begin_homing(Nanoseconds now);
  void end_homing(Nanoseconds now);
  void halt(Nanoseconds now);
  void alarm(int code, bool locked_up);
  void rest();
  std::string status() const;
  double steps_per_mm(int axis) const { return settings_.at(100 + axis); }
  std::array<std::int64_t, kAxes> steps_at(Nanoseconds now) const;

  Options options_;
  Machine machine_;
  std::map<int, double> settings_;
  std::array<double, kAxes> offset_mm_{};  // G54
  State state_ = State::kIdle;
  bool locked_up_ = false;  // after a critical alarm: only a reset helps
  bool homed_ = false, absolute_ = true, inches_ = false, hit_limit_ = false;
  double feed_ = 0;
  std::array<std::int64_t, kAxes> steps_{};      // machine position
  std::array<std::int64_t, kAxes> rested_at_{};  // when the machine was told last
  Move move_;
  bool in_move_ = false;
  std::deque<Move> planned_;
  Nanoseconds dwell_until_ = 0;
  Nanoseconds homing_until_ = 0;
  bool homing_ok_ = true, dwelling_ = false;
  std::string partial_;            // a line without its end
  std::deque<std::string> lines_;  // received, not yet executed
  std::string out_;
  Nanoseconds now_ = 0;
};

}  // namespace wheatstone
