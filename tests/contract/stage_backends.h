#pragma once
// Everything that is a stage, for tests that do not know which: twins, and real drivers on emulated
// controllers at the other end of a pseudo-terminal.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "hardware/serial/arduino_gantry.h"
#include "hardware/serial/grbl.h"
#include "sim/simulated_rig.h"
#include "sim/stage.h"
#include "sim/wire/arduino_gantry_firmware.h"
#include "sim/wire/grbl_firmware.h"
#include "sim/wire/pty_peer.h"

namespace wheatstone {

class StageBackend {
 public:
  virtual ~StageBackend() = default;
  virtual LinearStage& stage() = 0;
  virtual Clock& clock() = 0;
  /// Where the carriage really is.
  virtual double truth_mm() = 0;
  virtual bool moves_now() = 0;
  /// stop() and cancellation end a move before its end.
  virtual bool can_be_stopped() const = 0;
  /// False on the simulated clock: moves are over when they return.
  virtual bool takes_real_time() const { return true; }
  virtual double settling_mm() const { return 0; }
};

class TwinStageBackend final : public StageBackend {
 public:
  LinearStage& stage() override { return stage_; }
  Clock& clock() override { return world_.clock; }
  double truth_mm() override { return world_.carriage_mm; }
  bool moves_now() override { return false; }
  bool can_be_stopped() const override { return false; }
  bool takes_real_time() const override { return false; }
  double settling_mm() const override { return 0.03; }  // six sigma
  World& world() { return world_; }

 private:
  World world_{"card", 0.02, 7};
  SimulatedStage stage_{world_};
};

/// The emulated controllers run so many times as fast as real ones; the Arduino's carriage crawls.
inline constexpr double kGrblSpeed = 20, kArduinoSpeed = 60;

class GrblBackend : public StageBackend {
 public:
  explicit GrblBackend(const GrblFirmware::Options& options = {}) : firmware_(options, {}) {}
  LinearStage& stage() override {
    if (!stage_) {
      auto controller =
          std::make_shared<GrblController>(GrblSettings{peer_.path(), 115200, nullptr}, soon());
      stage_ = std::make_unique<GrblRail>(std::move(controller), GrblAxisSettings{0, 167});
    }
    return *stage_;
  }
  Clock& clock() override { return clock_; }
  double truth_mm() override {
    double mm = 0;
    peer_.with_firmware([&] { mm = firmware_.place(0); });
    return mm;
  }
  bool moves_now() override {
    bool moving = false;
    peer_.with_firmware([&] { moving = firmware_.moving(); });
    return moving;
  }
  bool can_be_stopped() const override { return true; }
  Deadline soon() { return clock_.in(Duration::of(5)); }
  PtyPeer& peer() { return peer_; }
  GrblFirmware& firmware() { return firmware_; }
  void close() { stage_.reset(); }

 private:
  SteadyClock clock_;
  GrblFirmware firmware_;
  PtyPeer peer_{firmware_, {}, kGrblSpeed};
  std::unique_ptr<GrblRail> stage_;
};

class ArduinoBackend : public StageBackend {
 public:
  explicit ArduinoBackend(const ArduinoGantryFirmware::Options& options = {5000, true})
      : firmware_(options, {}) {}
  LinearStage& stage() override {
    if (!stage_) {
      ArduinoGantrySettings settings;
      settings.port = peer_.path();
      stage_ = std::make_unique<ArduinoGantry>(settings);
    }
    return *stage_;
  }
  Clock& clock() override { return clock_; }
  double truth_mm() override {
    double mm = 0;
    peer_.with_firmware(
        [&] { mm = 167.0 * firmware_.carriage_pulses() / ArduinoGantryFirmware::kFullTravel; });
    return mm;
  }
  bool moves_now() override {
    bool moving = false;
    peer_.with_firmware([&] { moving = firmware_.moving(); });
    return moving;
  }
  bool can_be_stopped() const override { return false; }
  PtyPeer& peer() { return peer_; }
  ArduinoGantryFirmware& firmware() { return firmware_; }
  void close() { stage_.reset(); }

 private:
  SteadyClock clock_;
  ArduinoGantryFirmware firmware_;
  PtyPeer peer_{firmware_, {}, kArduinoSpeed};
  std::unique_ptr<ArduinoGantry> stage_;
};

}  // namespace wheatstone
