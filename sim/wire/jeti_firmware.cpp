#include "sim/wire/jeti_firmware.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <mutex>
#include <optional>
#include <sstream>
#include <utility>

namespace wheatstone {
namespace {

constexpr std::size_t kLongestLine = 80;
constexpr char kEscape = 27;
constexpr int kUnknownCommand = 4, kNotDigit = 8, kArgument = 10, kNoMeasurement = 131;

enum class Command {
  kIdentity,
  kVersion,
  kNumber,
  kDefault,
  kCalibration,
  kExposure,
  kFirst,
  kLast,
  kLongest,
  kFunction,
  kFormat,
  kRange,
  kAverage,
  kCycleMode,
  kCycle,
  kHead,
  kLaser,
  kAskLaser,
  kCycleMeasure,
  kInit,
  kXyz,
  kPhotometric,
  kChromaticity,
  kSpectrum,
  kError
};

struct Entry {
  const char* words;  // in full
  Command command;
  int arguments;
};
constexpr Entry kCommands[] = {
    {"IDN?", Command::kIdentity, 0},
    {"VERSION?", Command::kVersion, 0},
    {"PARAMETER:SPNUMBER?", Command::kNumber, 0},
    {"PARAMETER:CALIBNUMBER", Command::kCalibration, 1},
    {"PARAMETER:EXPOSURE", Command::kExposure, 1},
    {"PARAMETER:WAVBEGIN?", Command::kFirst, 0},
    {"PARAMETER:WAVEND?", Command::kLast, 0},
    {"CONFIGURE:DEFAULT", Command::kDefault, 0},
    {"CONFIGURE:MAXTINT", Command::kLongest, 1},
    {"CONFIGURE:FUNCTION", Command::kFunction, 1},
    {"CONFIGURE:FORMAT", Command::kFormat, 1},
    {"CONFIGURE:WRANGE", Command::kRange, 3},
    {"CONFIGURE:AVERAGE", Command::kAverage, 1},
    {"CONFIGURE:CYCMODE", Command::kCycleMode, 1},
    {"CONFIGURE:CYCTIME", Command::kCycle, 1},
    {"CONTROL:MHEAD?", Command::kHead, 0},
    {"CONTROL:LASER", Command::kLaser, 1},
    {"CONTROL:LASER?", Command::kAskLaser, 0},
    {"CONTROL:CYCTIME", Command::kCycleMeasure, 2},
    {"INITIATE", Command::kInit, 0},
    {"FETCH:XYZ", Command::kXyz, 0},
    {"FETCH:PHOTOMETRIC", Command::kPhotometric, 0},
    {"FETCH:CHROMXY", Command::kChromaticity, 0},
    {"FETCH:SPRAD", Command::kSpectrum, 0},
    {"STATUS:ERROR?", Command::kError, 0},
};

/// Each word of the command cut at will, the question mark kept.
bool is_stem(std::string_view cut, std::string_view full) {
  for (;;) {
    const std::size_t a = cut.find(':'), b = full.find(':');
    if ((a == std::string_view::npos) != (b == std::string_view::npos)) return false;
    std::string_view word = cut.substr(0, a), whole = full.substr(0, b);
    if (word.ends_with('?') != whole.ends_with('?')) return false;
    if (word.ends_with('?')) {
      word.remove_suffix(1);
      whole.remove_suffix(1);
    }
    if (word.empty() || !whole.starts_with(word)) return false;
    if (a == std::string_view::npos) return true;
    cut.remove_prefix(a + 1);
    full.remove_prefix(b + 1);
  }
}

/// Nothing: no such command, or a stem of several.
const Entry* find_command(const std::string& words) {
  const Entry* found = nullptr;
  for (const Entry& entry : kCommands) {
    if (!is_stem(words, entry.words)) continue;
    if (found) return nullptr;
    found = &entry;
  }
  return found;
}

}  // namespace

void JetiFirmware::receive(std::string_view bytes, Nanoseconds now) {
  for (const char c : bytes) {
    if (c == kEscape) {
      line_.clear();
      if (measuring()) {
        done_ = kNever;
        stuck_ = false;
        nak(147);
      }
    } else if (c == '\r') {
      command(std::exchange(line_, {}), now);
    } else if (line_.size() < kLongestLine) {
      line_ += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    }
  }
}

void JetiFirmware::nak(int code) {
  error_ = code;
  answers_ += '\x15';
}

void JetiFirmware::command(const std::string& line, Nanoseconds now) {
  if (measuring()) return;  // it listens to ESC only
  std::istringstream words(line);
  std::string verb;
  words >> verb;
  const Entry* entry = verb.starts_with('*') ? find_command(verb.substr(1)) : nullptr;
  if (!entry) return nak(kUnknownCommand);
  std::array<double, 3> argument{};
  for (int i = 0; i < entry->arguments; ++i)
    if (!(words >> argument[static_cast<std::size_t>(i)])) return nak(kNotDigit);
  if (entry->command == Command::kIdentity) return text(name);
  if (!answer_instead.empty()) {
    answers_ += answer_instead;
    return;
  }
  const bool good = exposure_.outcome == SpectroradiometerModel::Exposure::Outcome::kGood &&
                    !exposure_.spectrum.values.empty();
  const auto between = [&](double value, double low, double high) {
    return value >= low && value <= high;
  };
  switch (entry->command) {
    case Command::kIdentity:
      return;
    case Command::kVersion:
      return text(version);
    case Command::kNumber:
      return text(fmt::format("spectrometer number: {}", number));
    case Command::kDefault:
      longest_s_ = 60;
      average_ = 1;
      synchronised_ = false;
      return ack();
    case Command::kCalibration:
    case Command::kExposure:
    case Command::kFunction:
    case Command::kFormat:
      return ack();
    case Command::kFirst:
      return text(fmt::format("Predefined start wave: {}", first_nm));
    case Command::kLast:
      return text(fmt::format("Predefined end wave: {}", last_nm));
    case Command::kLongest:
      if (!between(argument[0], 1, 60000)) return nak(kArgument);
      longest_s_ = argument[0] / 1000;
      return ack();
    case Command::kRange:
      if (!between(argument[0], first_nm, last_nm)) return nak(kArgument);
      if (!between(argument[1], argument[0] + 1, last_nm)) return nak(kArgument + 1);
      if (argument[2] != 1) return nak(kArgument + 2);
      wanted_first_nm_ = static_cast<int>(argument[0]);
      wanted_last_nm_ = static_cast<int>(argument[1]);
      return ack();
    case Command::kAverage:
      if (!between(argument[0], 1, 100)) return nak(kArgument);
      average_ = static_cast<int>(argument[0]);
      return ack();
    case Command::kCycleMode:
      synchronised_ = argument[0] != 0;
      return ack();
    case Command::kCycle:
      period_s_ = argument[0] * 1e-6;
      return ack();
    case Command::kCycleMeasure:
      return text("cyctim[ms]: 0");  // the twin's light does not flicker
    case Command::kHead:
      return text(fmt::format("mhead: {}", diffuser_on ? 1 : 0));
    case Command::kLaser:
      laser_ = argument[0] != 0 || laser_stuck;
      return ack();
    case Command::kAskLaser:
      return text(fmt::format("laser: {}", laser_ ? 1 : 0));
    case Command::kInit: {
      const std::lock_guard lock(world_.mutex);
      exposure_ = model_.expose(longest_s_, average_, measurements_++);
      done_ = now + static_cast<Nanoseconds>(
                        1e9 * (kMeterOverheadS + 2 * average_ * exposure_.integration_s));
      stuck_ = never_done;
      if (stuck_) done_ = kNever;
      return ack();
    }
    case Command::kXyz: {
      if (!has_xyz) return nak(kUnknownCommand);
      if (!good) return nak(kNoMeasurement);
      const Eigen::Vector3d xyz = own_xyz();
      text(fmt::format("X: {:.6g}", xyz.x()));
      text(fmt::format("Y: {:.6g}", xyz.y()));
      return text(fmt::format("Z: {:.6g}", xyz.z()));
    }
    case Command::kPhotometric:
      if (!good) return nak(kNoMeasurement);
      return text(fmt::format("Luminance[cd/m^2]: {:.6g}", own_xyz().y()));
    case Command::kChromaticity: {
      if (!good) return nak(kNoMeasurement);
      const Eigen::Vector3d xyz = own_xyz() / own_xyz().sum();
      return text(fmt::format("Chrom_x: {:.5f} Chrom_y: {:.5f}", xyz.x(), xyz.y()));
    }
    case Command::kSpectrum:
      if (!good) return nak(kNoMeasurement);
      if (!calibrated_widely && (wanted_first_nm_ < 380 || wanted_last_nm_ > 780)) return nak(141);
      answers_ += spectrum();
      return;
    case Command::kError:
      return text(fmt::format("Error Code: {} ", error_));
  }
}

Eigen::Vector3d JetiFirmware::own_xyz() const {
  return xyz_factor * xyz_cd_m2(exposure_.spectrum);
}

std::string JetiFirmware::spectrum() {
  const bool lossy = lose_lines_of > 0;
  if (lossy) --lose_lines_of;
  std::string out = "Spectral radiance[W/(sr*m^2*nm)]\r";
  out += fmt::format("{} nm to {} nm\r", wanted_first_nm_, wanted_last_nm_);
  const SpectralRadiance& s = exposure_.spectrum;
  for (int nm = wanted_first_nm_; nm <= wanted_last_nm_; ++nm) {
    const auto k = static_cast<std::ptrdiff_t>(std::lround((nm - s.first_nm) / s.step_nm));
    const bool inside = k >= 0 && k < std::ssize(s.values);
    out += fmt::format("{:.5E}\r", inside ? s.values[static_cast<std::size_t>(k)] : 0.0);
  }
  if (lossy) out.erase(out.size() / 2, 100);  // as an overrun of the adapter's buffer does
  return out;
}

void JetiFirmware::finish() {
  done_ = kNever;
  using Outcome = SpectroradiometerModel::Exposure::Outcome;
  if (refuse_with != 0)
    nak(refuse_with);
  else if (exposure_.outcome != Outcome::kGood)
    nak(exposure_.outcome == Outcome::kTooBright ? 120 : 121);
  else
    answers_ += '\x07';
}

std::string JetiFirmware::run(Nanoseconds now) {
  if (done_ <= now) finish();
  std::string out = std::exchange(answers_, {});
  if (enq_every <= 0) return out;
  std::string with;
  for (const char c : out) {
    with += c;
    if (++sent_ % static_cast<std::size_t>(enq_every) == 0) with += '\x05';
  }
  return with;
}

Nanoseconds JetiFirmware::next_event() const {
  return done_;
}

}  // namespace wheatstone
