#pragma once
// The simulated rail and turning platform.

#include "hardware/stage.h"
#include "sim/world.h"

namespace wheatstone {

class SimulatedStage final : public LinearStage {
 public:
  explicit SimulatedStage(World& world) : world_(world) {}

  DeviceIdentity identity() const override;
  Length travel() const override { return Length::of(kStageTravelMm); }
  Length resolution() const override { return Length::of(1 / kStageStepsPerMm); }
  Duration move_duration(Length distance) const override;
  Duration home_duration() const override { return move_duration(travel()); }
  StageState state() const override { return state_; }
  Length home(Deadline) override;
  Length move_to(Length, Deadline) override;
  Length position(Deadline) override;
  bool position_is_measured() const override { return true; }
  void stop() noexcept override {}  // moves are over when they return

 private:
  void spend(double distance_mm, const Deadline&);
  void require_homed() const;

  World& world_;
  StageState state_ = StageState::kUnknown;
  double encoder_mm_ = 0;
};

/// Turns the box by up to 200 degrees, in steps of 0.05.
class SimulatedPlatform final : public RotaryStage {
 public:
  explicit SimulatedPlatform(World& world) : world_(world) {}

  DeviceIdentity identity() const override;
  Angle travel() const override { return degrees(200); }
  Angle resolution() const override { return degrees(0.05); }
  Duration move_duration(Angle distance) const override;
  Duration home_duration() const override { return move_duration(travel()); }
  StageState state() const override { return state_; }
  Angle home(Deadline) override;
  Angle move_to(Angle, Deadline) override;
  Angle position(Deadline) override;
  bool position_is_measured() const override { return false; }
  void stop() noexcept override {}

 private:
  void spend(Angle distance, const Deadline&);
  void require_homed() const;

  World& world_;
  StageState state_ = StageState::kUnknown;
};

}  // namespace wheatstone
