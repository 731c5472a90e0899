#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "sim/wire/serial_firmware.h"

namespace wheatstone {

/// The reference rig's Arduino sketch with all its traps (reference gantry_and_rotary.md, section
/// 1): one axis of 27000 pulses, commands of one byte, no framing, homing in silence.
class ArduinoGantryFirmware final : public SerialFirmware {
 public:
  static constexpr std::int32_t kFullTravel = 27000;

  struct Options {
    std::int32_t start_pulses = 5000;  // from home, before the first homing
    bool switch_works = true;
  };
  struct Machine {
    std::function<void()> homed;
    std::function<void(std::int32_t pulses)> moved;  // where the carriage really rests
  };

  ArduinoGantryFirmware() : ArduinoGantryFirmware(Options{}, {}) {}
  ArduinoGantryFirmware(Options, Machine);

  void receive(std::string_view, Nanoseconds now) override;
  std::string run(Nanoseconds now) override;
  Nanoseconds next_event() const override;

  // What a test may look at and do.
  bool homing() const { return state_ == State::kHoming; }
  bool moving() const { return state_ == State::kMoving || state_ == State::kHoming; }
  std::int32_t carriage_pulses() const { return carriage_; }
  int count() const { return count_; }  // what the sketch believes
  /// Pulses that move nothing, as when the motor stalls.
  void lose_steps(std::int32_t pulses) { lost_ += pulses; }
  void restart() { start_homing(now_); }

 private:
  enum class State { kHoming, kReady, kNumber, kMoving, kRunning };

  void start_homing(Nanoseconds now);
  void take(char, Nanoseconds now);
  void number_ended(Nanoseconds now);
  void go_to(std::int16_t target, Nanoseconds now);
  void stop_running(Nanoseconds now);
  void settle(std::int32_t pulses);
  std::int64_t pulse_ns() const { return 2000LL * half_period_us_; }

  Options options_;
  Machine machine_;
  State state_ = State::kHoming;
  Nanoseconds now_ = 0, since_ = 0, until_ = kNever;
  std::int16_t count_ = 0, target_ = 0;
  std::int32_t carriage_ = 0, lost_ = 0;
  std::uint16_t half_period_us_ = 600;
  int direction_ = 0;
  char number_command_ = 0;
  std::string number_, waiting_, out_;
};

}  // namespace wheatstone
