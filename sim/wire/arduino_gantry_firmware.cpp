#include "sim/wire/arduino_gantry_firmware.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace wheatstone {
namespace {

constexpr Nanoseconds kHomingPulseNs = 1'200'000, kBootNs = 2'000'000'000,
                      kNumberQuietNs = 1'000'000'000;
constexpr std::size_t kReceiveBuffer = 64;
constexpr int kPulsesPerPercent = 270;

}  // namespace

ArduinoGantryFirmware::ArduinoGantryFirmware(Options options, Machine machine)
    : options_(options), machine_(std::move(machine)), carriage_(options.start_pulses) {
  start_homing(0);
  until_ = until_ == kNever ? kNever : until_ + kBootNs;
}

void ArduinoGantryFirmware::start_homing(Nanoseconds now) {
  state_ = State::kHoming;
  since_ = now;
  until_ = options_.switch_works ? now + carriage_ * kHomingPulseNs : kNever;
  half_period_us_ = 600;
  waiting_.clear();
  number_.clear();
}

void ArduinoGantryFirmware::receive(std::string_view bytes, Nanoseconds now) {
  out_ += run(now);
  for (const char c : bytes) {
    if (state_ == State::kHoming) continue;  // its receiver is off
    if (state_ == State::kMoving) {
      if (waiting_.size() < kReceiveBuffer) waiting_ += c;
    } else {
      take(c, now);
    }
  }
}

void ArduinoGantryFirmware::take(char c, Nanoseconds now) {
  if (state_ == State::kNumber) {
    number_ += c;
    until_ = now + kNumberQuietNs;
    return;
  }
  switch (c) {
    case '1':
    case '2':
      stop_running(now);
      state_ = State::kRunning;
      direction_ = c == '1' ? 1 : -1;
      since_ = now;
      break;
    case '0':
      stop_running(now);
      out_ += std::to_string(count_ / kPulsesPerPercent) + "\r\n";
      break;
    case 'm':
    case 'x':
      stop_running(now);
      state_ = State::kNumber;
      number_command_ = c;
      number_.clear();
      until_ = now + kNumberQuietNs;
      break;
    case 'f':
    case 'b':
      stop_running(now);
      go_to(static_cast<std::int16_t>(count_ + (c == 'f' ? 1 : -1) * kPulsesPerPercent), now);
      break;
    case 'r':
      stop_running(now);
      start_homing(now);
      break;
    default:
      break;
  }
}

void ArduinoGantryFirmware::number_ended(Nanoseconds now) {
  const long value = std::strtol(number_.c_str(), nullptr, 10);
  state_ = State::kReady;
  until_ = kNever;
  if (number_command_ == 'm')
    go_to(static_cast<std::int16_t>(value * kPulsesPerPercent), now);
  else
    half_period_us_ = static_cast<std::uint16_t>(1100 - 100 * value);
}

void ArduinoGantryFirmware::go_to(std::int16_t target, Nanoseconds now) {
  target_ = target;
  state_ = State::kMoving;
  since_ = now;
  until_ = now + std::abs(target_ - count_) * pulse_ns();
}

/// The free run, which the sketch itself ends at 0 and at full travel.
void ArduinoGantryFirmware::stop_running(Nanoseconds now) {
  if (state_ != State::kRunning) return;
  const auto pulses =
      static_cast<std::int32_t>((now - since_) / std::max<std::int64_t>(1, pulse_ns()));
  const std::int32_t to = std::clamp(count_ + direction_ * pulses, 0, kFullTravel);
  settle(to - count_);
  count_ = static_cast<std::int16_t>(to);
  state_ = State::kReady;
  until_ = kNever;
}

/// The carriage follows the pulses, but not those that are lost nor beyond its ends.
void ArduinoGantryFirmware::settle(std::int32_t pulses) {
  const std::int32_t lost = std::min(std::abs(pulses), lost_);
  lost_ -= lost;
  const std::int32_t before = carriage_;
  carriage_ = std::clamp(carriage_ + (pulses > 0 ? pulses - lost : pulses + lost), 0, kFullTravel);
  if (carriage_ != before && machine_.moved) machine_.moved(carriage_);
}

std::string ArduinoGantryFirmware::run(Nanoseconds now) {
  now_ = now;
  while (until_ <= now) {
    const Nanoseconds at = until_;
    switch (state_) {
      case State::kHoming:
        state_ = State::kReady;
        until_ = kNever;
        carriage_ = 0;
        count_ = 0;
        if (machine_.homed) machine_.homed();
        break;
      case State::kNumber:
        number_ended(at);
        break;
      case State::kMoving: {
        settle(target_ - count_);
        count_ = target_;
        state_ = State::kReady;
        until_ = kNever;
        out_ += "End\r\n";
        const std::string waited = std::exchange(waiting_, {});
        for (std::size_t i = 0; i < waited.size(); ++i) {
          if (state_ == State::kMoving) waiting_ = waited.substr(i);
          if (state_ == State::kMoving || state_ == State::kHoming) break;
          take(waited[i], at);
        }
        break;
      }
      default:
        until_ = kNever;
    }
  }
  return std::exchange(out_, {});
}

Nanoseconds ArduinoGantryFirmware::next_event() const {
  return until_;
}

}  // namespace wheatstone
