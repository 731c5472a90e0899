#pragma once
// Rail and turning platform on a GRBL 1.1 controller (reference gantry_and_rotary.md, section 2).

#include <array>
#include <atomic>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "hardware/serial/grbl_message.h"
#include "hardware/stage.h"
#include "hardware/transport/serial_port.h"

namespace wheatstone {

struct GrblSettings {
  std::filesystem::path port;
  int baud = 115200;
  std::shared_ptr<Transcript> transcript;
};

/// The controller itself, shared by its axes; one call at a time for both of them together.
/// Axis 0 is X, 1 is Y. Positions are in the controller's unit (mm; degrees on a rotary axis), 0
/// where homing ends, positive away from the switch.
class GrblController {
 public:
  /// Resets it softly and reads its settings. Throws as SerialPort; kProtocol for another firmware,
  /// kRefused for settings under which positions could be wrong (inches, no machine position in
  /// reports, homing or soft limits off), naming the setting to change.
  GrblController(const GrblSettings&, const Deadline&);

  const std::string& version() const { return version_; }
  const std::filesystem::path& path() const { return port_.path(); }
  double setting(int number) const;

  StageState state(int axis) const;
  /// Homes all axes of the controller.
  void home(const Deadline&);
  double move(int axis, double position, const Deadline&);
  double position(int axis, const Deadline&);
  void stop() noexcept;

 private:
  struct Status {
    std::string state;
    std::vector<double> mpos;
  };

  void reset(const Deadline&);
  void read_settings(const Deadline&);
  GrblMessage next(const Deadline&);
  void command(const std::string& line, const Deadline&);
  void wait_for_ok(const Deadline&);
  Status status(const Deadline&);
  void come_to_a_stand();
  void lose_position() { state_ = StageState::kUnknown; }
  [[noreturn]] void on_alarm(int number);

  SerialPort port_;
  std::string version_;
  std::map<int, double> settings_;
  std::atomic<StageState> state_ = StageState::kUnknown;
  std::array<double, 2> home_mpos_{};
  std::array<double, 2> away_{-1, -1};  // direction of positive positions in machine coordinates
  std::atomic<bool> stop_ = false;
};

struct GrblAxisSettings {
  int axis = 0;       // 0: X, 1: Y
  double travel = 0;  // mm, or degrees
};

template <class P>
class GrblAxis final : public Stage<P> {
 public:
  /// Throws DeviceError kOutOfRange when the controller's own travel is shorter than the setting's.
  GrblAxis(std::shared_ptr<GrblController>, const GrblAxisSettings&);
  ~GrblAxis() override = default;

  DeviceIdentity identity() const override;
  P travel() const override;
  P resolution() const override;
  Duration move_duration(P distance) const override;
  Duration home_duration() const override;
  StageState state() const override { return controller_->state(axis_.axis); }
  P home(Deadline) override;
  P move_to(P, Deadline) override;
  P position(Deadline) override;
  bool position_is_measured() const override { return false; }
  void stop() noexcept override { controller_->stop(); }

 private:
  std::shared_ptr<GrblController> controller_;
  GrblAxisSettings axis_;
};

using GrblRail = GrblAxis<Length>;
using GrblPlatform = GrblAxis<Angle>;

}  // namespace wheatstone
