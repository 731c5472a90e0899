#include "hardware/serial/arduino_gantry.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr std::size_t kLongestReply = 16;
constexpr int kPulses = 27000;
constexpr double kHomingPulseS = 0.0012, kBootS = 2, kNumberQuietS = 1, kMarginS = 2;
constexpr Nanoseconds kAskEveryNs = 500'000'000;

ArduinoGantrySettings checked(const ArduinoGantrySettings& s) {
  if (!(s.travel_mm > 0 && std::isfinite(s.travel_mm)))
    throw ArgumentError("the travel of the gantry is not above 0 mm", "measure it");
  if (s.full_scale < 1 || s.full_scale > 121)
    throw ArgumentError(fmt::format("the gantry's full scale {} is outside 1..121", s.full_scale),
                        "use 100, or what the sketch was changed to");
  if (s.speed < 0 || s.speed > 10)
    throw ArgumentError(fmt::format("the gantry's speed {} is outside 1..10", s.speed),
                        "use 1 to 10, or 0 to leave it");
  return s;
}

std::optional<int> number_of(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

Deadline sooner(const Deadline& deadline, double seconds) {
  return {std::min(deadline.at_ns, SteadyClock().in(Duration::of(seconds)).at_ns), deadline.cancel};
}

}  // namespace

ArduinoGantry::ArduinoGantry(const ArduinoGantrySettings& settings)
    : settings_(checked(settings)),
      port_("the gantry on " + settings.port.string(), settings.port, 9600, settings.transcript) {}

DeviceIdentity ArduinoGantry::identity() const {
  return {"arduino-gantry", "Arduino sketch of the reference rig", "", "", port_.path().string()};
}

double ArduinoGantry::pulse_s() const {
  return settings_.speed == 0 ? 0.0012 : 2e-6 * (1100 - 100 * settings_.speed);
}

Duration ArduinoGantry::move_duration(Length distance) const {
  return Duration::of(kNumberQuietS + 0.1 + distance / travel() * kPulses * pulse_s());
}

Duration ArduinoGantry::home_duration() const {
  return Duration::of(kBootS + kPulses * kHomingPulseS + kMarginS);
}

std::string ArduinoGantry::line(const Deadline& deadline) {
  std::string text = port_.read_line('\n', kLongestReply, deadline);
  if (!text.empty() && text.back() == '\r') text.pop_back();
  return text;
}

int ArduinoGantry::ask_position(const Deadline& deadline) {
  port_.write("0", deadline);
  const std::string answer = line(deadline);
  const auto number = number_of(answer);
  if (!number)
    throw DeviceError(Kind::kProtocol,
                      fmt::format("{} answers with nonsense ({})", port_.what(), hex_of(answer)),
                      "check cable and speed, then home it again");
  return *number;
}

Length ArduinoGantry::home(Deadline deadline) {
  stop_ = false;
  state_ = StageState::kUnknown;
  port_.discard_input();
  port_.write("r", deadline);
  // In silence, and deaf. The only way to learn that it is over is to ask until it answers. One
  // answer may be a late one to an earlier question; after two in a row it listens.
  const SteadyClock clock;
  for (int in_a_row = 0; in_a_row < 2;) {
    port_.write("0", deadline);
    const auto answer = port_.try_read_line(
        '\n', kLongestReply,
        {std::min(deadline.at_ns, clock.now_ns() + kAskEveryNs), deadline.cancel});
    if (answer && (*answer == "0\r" || *answer == "0")) {
      ++in_a_row;
      continue;
    }
    in_a_row = 0;
    // A late answer to an earlier order: that one may have swallowed the order to home.
    if (answer) port_.write("r", deadline);
    if (answer && *answer != "End\r" && !number_of(answer->substr(0, answer->find('\r'))))
      throw DeviceError(
          Kind::kProtocol,
          fmt::format("{} answers with nonsense after homing ({})", port_.what(), hex_of(*answer)),
          "check that the sketch of the reference rig runs on it");
    if (clock.now_ns() >= deadline.at_ns)
      throw DeviceError(Kind::kTimeout,
                        port_.what() + " did not find home in time and may still be running",
                        "switch its motor off, check the home switch, then home it again");
  }
  set_speed(deadline);
  place_ = 0;
  state_ = StageState::kIdle;
  return Length::of(0);
}

/// Answers nothing; what comes within a second would be taken for more digits.
void ArduinoGantry::set_speed(const Deadline& deadline) {
  if (settings_.speed == 0) return;
  port_.write(fmt::format("x{}", settings_.speed), deadline);
  const Deadline quiet = SteadyClock().in(Duration::of(1.1 * kNumberQuietS));
  if (port_.try_read_line('\n', kLongestReply, {quiet.at_ns, deadline.cancel}))
    throw DeviceError(Kind::kProtocol, port_.what() + " answers where it should be silent",
                      "check that the sketch of the reference rig runs on it");
  if (ask_position(deadline) != 0)
    throw DeviceError(Kind::kFault, port_.what() + " has left home by itself", "home it again");
}

void ArduinoGantry::require_homed() const {
  if (state_ != StageState::kIdle)
    throw DeviceError(Kind::kNotReady, "the stage does not know its position", "home it first");
}

Length ArduinoGantry::move_to(Length target, Deadline deadline) {
  require_homed();
  if (!(target >= Length::of(0) && target <= travel()))
    throw DeviceError(Kind::kOutOfRange,
                      fmt::format("position {} mm is beyond the stage's travel", target.value()),
                      fmt::format("use 0 to {} mm", settings_.travel_mm));
  if (deadline.cancel.stop_requested()) throw Cancelled(port_.what() + ": stopped on request");
  const int place = static_cast<int>(std::lround(target / travel() * settings_.full_scale));
  const double pulses =
      std::abs(place - place_) * static_cast<double>(kPulses) / settings_.full_scale;
  stop_ = false;
  state_ = StageState::kMoving;
  const std::string answer = [&] {
    try {
      // In one piece: a pause would end the number. Then not even a request to stop may send more.
      port_.write(fmt::format("m{}", place), deadline);
      return line(sooner({deadline.at_ns}, kNumberQuietS + pulses * pulse_s() + kMarginS));
    } catch (const Error&) {
      state_ = StageState::kUnknown;
      throw;
    }
  }();
  if (answer != "End") {
    state_ = StageState::kUnknown;
    throw DeviceError(Kind::kProtocol,
                      fmt::format("{} answers with nonsense ({})", port_.what(), hex_of(answer)),
                      "check cable and speed, then home it again");
  }
  place_ = place;
  state_ = StageState::kIdle;
  const Length reached = place * resolution();
  if (deadline.cancel.stop_requested())
    throw Cancelled(fmt::format("{}: could not be stopped while it moved; it stands at {:.3f} mm",
                                port_.what(), reached.value()));
  if (stop_)
    throw DeviceError(Kind::kRefused,
                      fmt::format("{} was stopped at the end of its move, at {:.3f} mm",
                                  port_.what(), reached.value()),
                      "move again when it is safe");
  return reached;
}

Length ArduinoGantry::position(Deadline deadline) {
  require_homed();
  int place = 0;
  try {
    place = ask_position(deadline);
  } catch (const Error&) {
    state_ = StageState::kUnknown;  // its answer may still come and be taken for another
    throw;
  }
  // The sketch truncates towards zero; a percent may be missing where it does not divide evenly.
  if (std::abs(place - place_ * 100.0 / settings_.full_scale) > 1.001) {
    state_ = StageState::kUnknown;
    throw DeviceError(Kind::kFault,
                      fmt::format("{} says that it stands at {} percent instead of {:.1f}",
                                  port_.what(), place, place_ * 100.0 / settings_.full_scale),
                      "home it again");
  }
  return place_ * resolution();
}

}  // namespace wheatstone
