#pragma once
// The rail of the reference rig: an Arduino sketch without framing, limits or a way to stop
// (reference gantry_and_rotary.md, section 1). Prefer GRBL: this one resolves whole percent only.

#include <atomic>
#include <filesystem>
#include <memory>

#include "hardware/stage.h"
#include "hardware/transport/serial_port.h"

namespace wheatstone {

struct ArduinoGantrySettings {
  std::filesystem::path port;
  double travel_mm = 167;
  int full_scale = 100;  // the number that the sketch takes for full travel
  int speed = 0;         // 1..10; 0: as the sketch starts
  std::shared_ptr<Transcript> transcript;
};

/// Never sends what the sketch does not survive: one command at a time, nothing before its answer,
/// no number outside 0..full_scale. It cannot be stopped while it moves: stop() and a request to
/// stop take effect when the move is over, then move_to() throws kRefused or Cancelled and the
/// position is still known. Lost steps cannot be seen.
class ArduinoGantry final : public LinearStage {
 public:
  /// Opens the line (which resets the board); home() is needed before anything else. Throws as
  /// SerialPort; ArgumentError for settings that make no sense: a travel that is not above 0, a
  /// full scale outside 1..121 (beyond, the sketch's 16 bits overflow), a speed outside 0..10.
  explicit ArduinoGantry(const ArduinoGantrySettings&);

  DeviceIdentity identity() const override;
  Length travel() const override { return Length::of(settings_.travel_mm); }
  Length resolution() const override {
    return Length::of(settings_.travel_mm / settings_.full_scale);
  }
  Duration move_duration(Length distance) const override;
  Duration home_duration() const override;
  StageState state() const override { return state_; }
  Length home(Deadline) override;
  Length move_to(Length, Deadline) override;
  Length position(Deadline) override;
  bool position_is_measured() const override { return false; }
  void stop() noexcept override { stop_ = true; }

 private:
  int ask_position(const Deadline&);
  std::string line(const Deadline&);
  void set_speed(const Deadline&);
  void require_homed() const;
  double pulse_s() const;

  ArduinoGantrySettings settings_;
  SerialPort port_;
  std::atomic<StageState> state_ = StageState::kUnknown;
  std::atomic<bool> stop_ = false;
  int place_ = 0;  // of full_scale
};

}  // namespace wheatstone
