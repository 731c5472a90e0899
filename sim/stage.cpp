#include "sim/stage.h"

#include <cmath>
#include <sstream>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr double kSpeedMmS = 50, kSettleS = 0.5;
constexpr double kTurnDegS = 20, kTurnSettleS = 1;

/// Waits out a move; kTimeout at the deadline, the carriage stands where it stood.
void wait_out(World& world, Duration move, const Deadline& deadline, const char* what) {
  const Nanoseconds done = world.clock.in(move).at_ns;
  if (done > deadline.at_ns) {
    world.clock.wait_until(deadline.at_ns);
    throw DeviceError(DeviceError::Kind::kTimeout,
                      std::string("the ") + what + " did not arrive in time",
                      "allow at least move_duration() for a move");
  }
  world.clock.wait_until(done);
}

DeviceError not_homed(const char* what) {
  return {DeviceError::Kind::kNotReady, std::string("the ") + what + " does not know its position",
          "home it first"};
}

template <class E>
bool loses_position(const E& e) {
  return e.kind() != DeviceError::Kind::kOutOfRange && e.kind() != DeviceError::Kind::kNotReady &&
         e.kind() != DeviceError::Kind::kTimeout && e.kind() != DeviceError::Kind::kRefused;
}

}  // namespace

DeviceIdentity SimulatedStage::identity() const {
  return {"simulated", "twin of the camera rail", "", "", ""};
}

Duration SimulatedStage::move_duration(Length distance) const {
  return Duration::of(distance.value() / kSpeedMmS + kSettleS);
}

Length SimulatedStage::home(Deadline deadline) {
  state_ = StageState::kUnknown;
  world_.faults.meet("stage", deadline);
  spend(world_.carriage_mm, deadline);
  world_.home_carriage();
  encoder_mm_ = 0;
  state_ = StageState::kIdle;
  return Length::of(0);
}

Length SimulatedStage::move_to(Length target, Deadline deadline) {
  require_homed();
  const double mm = target.value();
  if (!(mm >= 0 && mm <= kStageTravelMm)) {
    std::ostringstream problem;
    problem << "position " << mm << " mm is beyond the stage's travel";
    throw DeviceError(DeviceError::Kind::kOutOfRange, problem.str(), "use 0 to 167 mm");
  }
  try {
    world_.faults.meet("stage", deadline);
  } catch (const DeviceError& e) {
    if (loses_position(e)) state_ = StageState::kUnknown;
    throw;
  }
  spend(std::abs(mm - world_.carriage_mm), deadline);
  encoder_mm_ = world_.move_carriage(std::round(mm * kStageStepsPerMm) / kStageStepsPerMm);
  return Length::of(encoder_mm_);
}

Length SimulatedStage::position(Deadline deadline) {
  require_homed();
  try {
    world_.faults.meet("stage", deadline);
  } catch (const DeviceError& e) {
    if (e.kind() == DeviceError::Kind::kDisconnected) state_ = StageState::kUnknown;
    throw;
  }
  return Length::of(encoder_mm_);
}

void SimulatedStage::spend(double distance_mm, const Deadline& deadline) {
  wait_out(world_, move_duration(Length::of(distance_mm)), deadline, "stage");
}

void SimulatedStage::require_homed() const {
  if (state_ != StageState::kIdle) throw not_homed("stage");
}

DeviceIdentity SimulatedPlatform::identity() const {
  return {"simulated", "twin of the turning platform", "", "", ""};
}

Duration SimulatedPlatform::move_duration(Angle distance) const {
  return Duration::of(to_degrees(distance) / kTurnDegS + kTurnSettleS);
}

Angle SimulatedPlatform::home(Deadline deadline) {
  state_ = StageState::kUnknown;
  world_.faults.meet("platform", deadline);
  spend(Angle::of(world_.platform_rad), deadline);
  world_.platform_rad = 0;
  state_ = StageState::kIdle;
  return Angle::of(0);
}

Angle SimulatedPlatform::move_to(Angle target, Deadline deadline) {
  require_homed();
  if (!(target >= Angle::of(0) && target <= travel())) {
    std::ostringstream problem;
    problem << "angle " << to_degrees(target) << " deg is beyond the platform's travel";
    throw DeviceError(DeviceError::Kind::kOutOfRange, problem.str(), "use 0 to 200 deg");
  }
  try {
    world_.faults.meet("platform", deadline);
  } catch (const DeviceError& e) {
    if (loses_position(e)) state_ = StageState::kUnknown;
    throw;
  }
  spend(Angle::of(std::abs(target.value() - world_.platform_rad)), deadline);
  const double steps = std::round(target / resolution());
  world_.platform_rad = steps * resolution().value();
  return Angle::of(world_.platform_rad);
}

Angle SimulatedPlatform::position(Deadline deadline) {
  require_homed();
  world_.faults.meet("platform", deadline);
  return Angle::of(world_.platform_rad);
}

void SimulatedPlatform::spend(Angle distance, const Deadline& deadline) {
  wait_out(world_, move_duration(distance), deadline, "platform");
}

void SimulatedPlatform::require_homed() const {
  if (state_ != StageState::kIdle) throw not_homed("platform");
}

}  // namespace wheatstone
