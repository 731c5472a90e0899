#include "hardware/serial/grbl.h"

#include <fmt/format.h>

#include <cmath>
#include <type_traits>

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;
using Type = GrblMessage::Type;

constexpr std::size_t kLongestReply = 256;
constexpr Nanoseconds kStopCheckNs = 20'000'000;
constexpr Nanoseconds kNoiseNs = 40'000'000, kBannerNs = 500'000'000, kStandNs = 2'000'000'000;

Deadline sooner(const Deadline& deadline, Nanoseconds from_now) {
  return {std::min(deadline.at_ns, SteadyClock().now_ns() + from_now), deadline.cancel};
}

char name_of(int axis) {
  return axis == 0 ? 'X' : 'Y';
}

}  // namespace

GrblController::GrblController(const GrblSettings& settings, const Deadline& deadline)
    : port_("the GRBL controller on " + settings.port.string(), settings.port, settings.baud,
            settings.transcript) {
  reset(deadline);
  read_settings(deadline);
}

double GrblController::setting(int number) const {
  const auto it = settings_.find(number);
  if (it == settings_.end())
    throw DeviceError(Kind::kProtocol, fmt::format("{} has no setting ${}", port_.what(), number),
                      "install GRBL 1.1");
  return it->second;
}

StageState GrblController::state(int) const {
  return state_;
}

/// To a known beginning, whatever went on before: opening the port resets many boards by itself,
/// and their boot loader swallows what comes in its two seconds.
void GrblController::reset(const Deadline& deadline) {
  lose_position();
  version_.clear();
  port_.discard_input();
  for (;;) {
    // The answer to the second order ends what came before it: older answers, further banners.
    port_.write("\x18$I\n", deadline);
    const Deadline patience = sooner(deadline, kBannerNs);
    try {
      while (const auto line = port_.try_read_line('\n', kLongestReply, patience)) {
        const GrblMessage message = parse_grbl(*line);
        if (message.type == Type::kBanner) version_ = message.text;
        if (message.type == Type::kOk && !version_.empty()) break;
      }
    } catch (const DeviceError& e) {
      if (e.kind() != Kind::kProtocol) throw;
      // Noise of a board that is booting: let some of it pass.
      SteadyClock clock;
      clock.wait_until(std::min(deadline.at_ns, clock.now_ns() + kNoiseNs));
    }
    if (version_.starts_with("1.1")) return;
    if (!version_.empty())
      throw DeviceError(Kind::kProtocol, fmt::format("{} runs Grbl {}", port_.what(), version_),
                        "install GRBL 1.1");
    if (SteadyClock().now_ns() >= deadline.at_ns)
      throw DeviceError(Kind::kTimeout, port_.what() + " does not answer with its name",
                        "check that it is a GRBL controller, its power and its speed");
  }
}

void GrblController::read_settings(const Deadline& deadline) {
  settings_.clear();
  port_.write("$$\n", deadline);
  for (;;) {
    const GrblMessage message = next(deadline);
    if (message.type == Type::kOk) break;
    if (message.type == Type::kError)
      throw DeviceError(Kind::kRefused, port_.what() + " does not tell its settings",
                        "switch it off and on");
    if (message.type == Type::kSetting) settings_[message.number] = message.value;
  }
  const auto require = [&](bool ok, const char* problem, const char* remedy) {
    if (!ok) throw DeviceError(Kind::kRefused, port_.what() + " " + problem, remedy);
  };
  require(setting(13) == 0, "reports inches", "send $13=0");
  require(static_cast<int>(setting(10)) & 1, "does not report machine positions", "send $10=1");
  require(setting(22) != 0, "does not home", "fit home switches and send $22=1");
  require(setting(20) != 0, "has its soft limits switched off", "send $20=1");
}

/// The next line that says something; fed to the caller's own waiting.
GrblMessage GrblController::next(const Deadline& deadline) {
  for (;;) {
    if (stop_.load()) {
      come_to_a_stand();
      throw DeviceError(Kind::kRefused, port_.what() + " was stopped",
                        "move again when it is safe");
    }
    const auto line = port_.try_read_line('\n', kLongestReply, sooner(deadline, kStopCheckNs));
    if (!line) {
      if (SteadyClock().now_ns() < deadline.at_ns) continue;
      throw DeviceError(Kind::kTimeout, port_.what() + " did not answer in time",
                        "check cable and power, then home it again");
    }
    if (line->empty() || *line == "\r") continue;
    GrblMessage message = parse_grbl(*line);
    switch (message.type) {
      case Type::kAlarm:
        on_alarm(message.number);
      case Type::kBanner:
        lose_position();
        throw DeviceError(Kind::kFault, port_.what() + " has restarted",
                          "check its power, then home it again");
      case Type::kOther:
        lose_position();
        throw DeviceError(Kind::kProtocol,
                          fmt::format("{} sends nonsense ({})", port_.what(), hex_of(*line)),
                          "check cable and speed, then home it again");
      default:
        return message;
    }
  }
}

void GrblController::on_alarm(int number) {
  lose_position();
  port_.write_now("\x18");  // after some alarms it answers nothing else
  throw DeviceError(
      Kind::kFault,
      fmt::format("{} reports alarm {}: {}", port_.what(), number, grbl_alarm_text(number)),
      "free the carriage, then home it again");
}

void GrblController::wait_for_ok(const Deadline& deadline) {
  for (;;) {
    const GrblMessage message = next(deadline);
    if (message.type == Type::kOk) return;
    if (message.type != Type::kError) continue;
    if (message.number == 9) {
      lose_position();
      throw DeviceError(Kind::kNotReady, port_.what() + " is locked", "home it first");
    }
    throw DeviceError(Kind::kRefused,
                      fmt::format("{} reports error {}: {}", port_.what(), message.number,
                                  grbl_error_text(message.number)),
                      "check the settings of the controller");
  }
}

void GrblController::command(const std::string& line, const Deadline& deadline) {
  port_.write(line + "\n", deadline);
  wait_for_ok(deadline);
}

GrblController::Status GrblController::status(const Deadline& deadline) {
  port_.write("?", deadline);
  for (;;) {
    GrblMessage message = next(deadline);
    if (message.type != Type::kStatus) continue;
    if (message.mpos.size() < 2)
      throw DeviceError(Kind::kProtocol, port_.what() + " reports no machine position",
                        "send $10=1");
    return {message.text, message.mpos};
  }
}

/// Decelerates, waits until it stands and clears the rest of the move; the position is kept if all
/// that succeeds, lost otherwise. Takes kStandNs at most.
void GrblController::come_to_a_stand() {
  stop_ = false;
  const Deadline deadline = {SteadyClock().now_ns() + kStandNs};
  const bool had_position = state_ != StageState::kUnknown;
  lose_position();
  try {
    port_.write("!", deadline);
    Status now;
    do {
      now = status({std::min(deadline.at_ns, SteadyClock().now_ns() + kBannerNs)});
    } while (now.state == "Run" || now.state == "Hold:1" || now.state == "Jog");
    port_.write("\x18", deadline);
    for (;;) {
      const auto line = port_.try_read_line('\n', kLongestReply, deadline);
      if (!line) return;
      const GrblMessage message = parse_grbl(*line);
      if (message.type == Type::kAlarm) return;
      if (message.type == Type::kBanner) break;
    }
    // A locked controller says so behind its banner; its status tells without waiting for that.
    if (had_position && status(deadline).state == "Idle") state_ = StageState::kIdle;
  } catch (const Error&) {  // the caller has a better one to report
    port_.write_now("\x18");
  }
}

void GrblController::home(const Deadline& deadline) {
  stop_ = false;
  reset(deadline);
  try {
    command("$H", deadline);
    const Status after = status(deadline);
    for (int a = 0; a < 2; ++a) {
      const auto i = static_cast<std::size_t>(a);
      home_mpos_[i] = after.mpos[i];
      // $23: bit set, the switch is at the negative end.
      away_[i] = (static_cast<int>(setting(23)) >> a) & 1 ? 1 : -1;
    }
    state_ = StageState::kIdle;
  } catch (const Error&) {
    port_.write_now("\x18");
    lose_position();
    throw;
  }
}

double GrblController::move(int axis, double target, const Deadline& deadline) {
  const auto i = static_cast<std::size_t>(axis);
  const double per_unit = setting(100 + axis);
  const double steps = std::round(target * per_unit);
  stop_ = false;
  state_ = StageState::kMoving;
  try {
    command(fmt::format("G90 G21 G53 G1 {}{:.4f} F{:.3f}", name_of(axis),
                        home_mpos_[i] + away_[i] * steps / per_unit, setting(110 + axis)),
            deadline);
    command("G4 P0.01", deadline);
    const Status after = status(deadline);
    const double reached = std::round((after.mpos[i] - home_mpos_[i]) * away_[i] * per_unit);
    if (after.state != "Idle" || std::abs(reached - steps) > 0.5) {
      lose_position();
      throw DeviceError(Kind::kFault,
                        fmt::format("{} stands at {:.3f} ({}) instead of {:.3f}", port_.what(),
                                    reached / per_unit, after.state, steps / per_unit),
                        "home it again");
    }
    state_ = StageState::kIdle;
    return reached / per_unit + 0.0;  // no minus before a zero
  } catch (const Cancelled&) {
    state_ = StageState::kIdle;  // kept if it comes to a stand in order
    come_to_a_stand();
    throw;
  } catch (const DeviceError& e) {
    if (e.kind() == Kind::kRefused) {
      if (state_ == StageState::kMoving) state_ = StageState::kIdle;  // it did not take the order
    } else {
      port_.write_now("!\x18");  // whatever it is doing
      lose_position();
    }
    throw;
  }
}

double GrblController::position(int axis, const Deadline& deadline) {
  const auto i = static_cast<std::size_t>(axis);
  const double per_unit = setting(100 + axis);
  try {
    const Status now = status(deadline);
    return std::round((now.mpos[i] - home_mpos_[i]) * away_[i] * per_unit) / per_unit + 0.0;
  } catch (const DeviceError& e) {
    // Its answer may still come: what follows could take it for another.
    if (e.kind() != Kind::kRefused) lose_position();
    throw;
  }
}

void GrblController::stop() noexcept {
  port_.write_now("!");
  stop_ = true;
}

template <class P>
GrblAxis<P>::GrblAxis(std::shared_ptr<GrblController> controller, const GrblAxisSettings& axis)
    : controller_(std::move(controller)), axis_(axis) {
  const double allowed = controller_->setting(130 + axis.axis) - controller_->setting(27);
  if (!(axis.travel > 0 && axis.travel <= allowed))
    throw DeviceError(
        DeviceError::Kind::kOutOfRange,
        fmt::format("a travel of {} on axis {} is beyond the {} that the controller "
                    "allows after homing",
                    axis.travel, name_of(axis.axis), allowed),
        fmt::format("correct the rig file, or ${} of the controller", 130 + axis.axis));
}

namespace {

// Between the rig's quantities and the controller's units.
template <class P>
P quantity(double units) {
  if constexpr (std::is_same_v<P, Angle>)
    return degrees(units);
  else
    return P::of(units);
}
double units(Length length) {
  return length.value();
}
double units(Angle angle) {
  return to_degrees(angle);
}

}  // namespace

template <class P>
DeviceIdentity GrblAxis<P>::identity() const {
  return {"grbl", fmt::format("axis {}", name_of(axis_.axis)), "", controller_->version(),
          controller_->path().string()};
}

template <class P>
P GrblAxis<P>::travel() const {
  return quantity<P>(axis_.travel);
}

template <class P>
P GrblAxis<P>::resolution() const {
  return quantity<P>(1 / controller_->setting(100 + axis_.axis));
}

template <class P>
Duration GrblAxis<P>::move_duration(P distance) const {
  const double speed = controller_->setting(110 + axis_.axis) / 60,
               rate = controller_->setting(120 + axis_.axis);
  const double d = units(distance);
  return Duration::of(
      0.05 + (d > speed * speed / rate ? d / speed + speed / rate : 2 * std::sqrt(d / rate)));
}

template <class P>
Duration GrblAxis<P>::home_duration() const {
  const double seek = controller_->setting(25) / 60, feed = controller_->setting(24) / 60;
  double longest = 0;  // it searches along one and a half times the travel
  for (int axis = 0; axis < 2; ++axis)
    longest += 1.5 * controller_->setting(130 + axis) / seek + 10 * controller_->setting(27) / feed;
  return Duration::of(5 + longest);
}

template <class P>
P GrblAxis<P>::home(Deadline deadline) {
  controller_->home(deadline);
  return quantity<P>(0);
}

template <class P>
P GrblAxis<P>::move_to(P target, Deadline deadline) {
  if (state() != StageState::kIdle)
    throw DeviceError(DeviceError::Kind::kNotReady, "the stage does not know its position",
                      "home it first");
  if (!(target >= quantity<P>(0) && target <= travel()))
    throw DeviceError(DeviceError::Kind::kOutOfRange,
                      fmt::format("position {} is beyond the stage's travel", units(target)),
                      fmt::format("use 0 to {}", axis_.travel));
  return quantity<P>(controller_->move(axis_.axis, units(target), deadline));
}

template <class P>
P GrblAxis<P>::position(Deadline deadline) {
  if (state() != StageState::kIdle)
    throw DeviceError(DeviceError::Kind::kNotReady, "the stage does not know its position",
                      "home it first");
  return quantity<P>(controller_->position(axis_.axis, deadline));
}

template class GrblAxis<Length>;
template class GrblAxis<Angle>;

}  // namespace wheatstone
