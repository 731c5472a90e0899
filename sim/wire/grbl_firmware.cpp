// What GrblFirmware hears and says; grbl_motion.cpp is how it moves.

#include "sim/wire/grbl_firmware.h"

#include <fmt/format.h>

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <set>
#include <utility>

namespace wheatstone {
namespace {

constexpr std::size_t kLongestLine = 80, kReceiveBuffer = 128, kPlannerBlocks = 15;

}  // namespace

GrblFirmware::GrblFirmware(Options options, Machine machine)
    : options_(std::move(options)), machine_(std::move(machine)) {
  settings_ = {{0, 10},     {1, 255},    {2, 0},     {3, 0},     {4, 0},     {5, 0},
               {6, 0},      {10, 1},     {11, .01},  {12, .002}, {13, 0},    {20, 1},
               {21, 1},     {22, 1},     {23, 0},    {24, 100},  {25, 1500}, {26, 25},
               {27, 1},     {30, 1000},  {31, 0},    {32, 0},    {100, 160}, {101, 20},
               {110, 3000}, {111, 1200}, {120, 500}, {121, 200}, {130, 175}, {131, 205}};
  for (int a = 0; a < kAxes; ++a)
    steps_[static_cast<std::size_t>(a)] =
        -std::llround(options_.start_mm[static_cast<std::size_t>(a)] * steps_per_mm(a));
  rested_at_ = steps_;
  reset(0, true);
}

void GrblFirmware::restart() {
  homed_ = false;
  if (in_move_) halt(now_);
  reset(now_, true);
}

void GrblFirmware::reset(Nanoseconds now, bool power_up) {
  now_ = now;
  const bool lock = power_up ? settings_[22] != 0 : state_ == State::kAlarm;
  planned_.clear();
  partial_.clear();
  lines_.clear();
  in_move_ = dwelling_ = locked_up_ = false;
  absolute_ = true;
  inches_ = false;
  feed_ = 0;
  state_ = lock ? State::kAlarm : State::kIdle;
  out_ += fmt::format("\r\nGrbl {} ['$' for help]\r\n", options_.version);
  if (lock) out_ += "[MSG:'$H'|'$X' to unlock]\r\n";
}

void GrblFirmware::receive(std::string_view bytes, Nanoseconds now) {
  advance(now);
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '?' || c == '!' || c == '~' || byte == 0x18 || byte >= 0x80) {
      real_time(c, now);
    } else if (c == '\n' || c == '\r') {
      finish_line(now);
    } else if (partial_.size() < kReceiveBuffer) {
      partial_ += c;
    }
  }
}

void GrblFirmware::finish_line(Nanoseconds now) {
  std::string line;
  bool comment = false;
  for (const char c : std::exchange(partial_, {})) {
    if (c == '(') comment = true;
    if (c == ';') break;
    if (!comment && c != ' ')
      line += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    if (c == ')') comment = false;
  }
  std::size_t waiting = 0;
  for (const std::string& l : lines_) waiting += l.size() + 1;
  if (waiting <= kReceiveBuffer) lines_.push_back(std::move(line));  // beyond, it is lost
  advance(now);
}

void GrblFirmware::real_time(char c, Nanoseconds now) {
  switch (static_cast<unsigned char>(c)) {
    case '?':
      if (state_ != State::kHoming) out_ += status();
      break;
    case '!':
      if (state_ == State::kRun) {
        halt(now);
        state_ = State::kHold;
      }
      break;
    case '~':
      if (state_ == State::kHold) {
        state_ = State::kIdle;
        start_next(now);
      }
      break;
    case 0x18: {
      const bool homing = state_ == State::kHoming, running = state_ == State::kRun;
      if (in_move_ || homing) halt(now);
      if (homing || running) alarm(homing ? 6 : 3, false);
      reset(now, false);
      break;
    }
    case 0x85:
      if (in_move_) {
        halt(now);
        planned_.clear();
        state_ = State::kIdle;
      }
      break;
    default:
      break;  // overrides: no spindle, no feed to change here
  }
}

std::string GrblFirmware::run(Nanoseconds now) {
  advance(now);
  return std::exchange(out_, {});
}

Nanoseconds GrblFirmware::next_event() const {
  if (state_ == State::kHoming) return homing_until_;
  if (in_move_) return move_.start + move_.duration;
  if (dwelling_) return dwell_until_;
  return kNever;
}

void GrblFirmware::advance(Nanoseconds now) {
  now_ = now;
  if (std::exchange(hit_limit_, false) && settings_[21] != 0) {
    if (in_move_) halt(now);
    homed_ = false;
    alarm(1, true);
  }
  if (state_ == State::kHoming && now >= homing_until_) end_homing(now);
  while (in_move_ && now >= move_.start + move_.duration) {
    const Nanoseconds end = move_.start + move_.duration;
    steps_ = move_.to;
    in_move_ = false;
    start_next(end);
    if (!in_move_) rest();
  }
  if (dwelling_ && !in_move_ && state_ != State::kHold) {
    if (dwell_until_ == kNever) dwell_until_ = now;  // motion has just ended
    if (now >= dwell_until_) {
      dwelling_ = false;
      out_ += "ok\r\n";
    }
  }
  while (!lines_.empty() && !dwelling_ && state_ != State::kHoming && !locked_up_ &&
         state_ != State::kHold && planned_.size() < kPlannerBlocks) {
    const std::string line = lines_.front();
    lines_.pop_front();
    execute(line, now);
  }
}

void GrblFirmware::execute(const std::string& line, Nanoseconds now) {
  if (line.size() > kLongestLine) {
    out_ += "error:11\r\n";
  } else if (line.empty()) {
    out_ += "ok\r\n";
  } else if (line[0] == '$') {
    system_command(line, now);
  } else if (state_ == State::kAlarm) {
    out_ += "error:9\r\n";
  } else if (const int error = gcode(line, now); error > 0) {
    out_ += fmt::format("error:{}\r\n", error);
  } else if (error == 0 && !dwelling_) {
    out_ += "ok\r\n";
  }
}

void GrblFirmware::system_command(const std::string& line, Nanoseconds now) {
  const auto answer = [&](const std::string& text) { out_ += text + "ok\r\n"; };
  if (line == "$") {
    answer("[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]\r\n");
  } else if (line == "$$") {
    std::string text;
    for (const auto& [number, value] : settings_)
      text += number < 100 && value == std::floor(value)
                  ? fmt::format("${}={:.0f}\r\n", number, value)
                  : fmt::format("${}={:.3f}\r\n", number, value);
    answer(text);
  } else if (line == "$I") {
    answer(fmt::format("[VER:{}.20190830:]\r\n[OPT:V,15,128]\r\n", options_.version));
  } else if (line == "$G") {
    answer(fmt::format("[GC:G{} G54 G17 G{} G{} G94 M5 M9 T0 F{:.0f} S0]\r\n", 0, inches_ ? 20 : 21,
                       absolute_ ? 90 : 91, feed_));
  } else if (line == "$#") {
    answer(fmt::format("[G54:{:.3f},{:.3f},0.000]\r\n[TLO:0.000]\r\n[PRB:0.000,0.000,0.000:0]\r\n",
                       offset_mm_[0], offset_mm_[1]));
  } else if (line == "$N") {
    answer("$N0=\r\n$N1=\r\n");
  } else if (line == "$X") {
    if (state_ == State::kAlarm) {
      state_ = State::kIdle;
      out_ += "[MSG:Caution: Unlocked]\r\n";
    }
    answer("");
  } else if (line == "$H") {
    if (settings_[22] == 0)
      out_ += "error:5\r\n";
    else
      begin_homing(now);
  } else if (line.starts_with("$J=")) {
    if (state_ == State::kAlarm) {
      out_ += "error:9\r\n";
      return;
    }
    const int error = gcode("G1" + line.substr(3), now);
    out_ += error ? fmt::format("error:{}\r\n", error == 2 ? 16 : error) : "ok\r\n";
  } else if (const auto equals = line.find('='); equals != std::string::npos && equals > 1) {
    char* end = nullptr;
    const long number = std::strtol(line.c_str() + 1, &end, 10);
    char* value_end = nullptr;
    const double value = std::strtod(line.c_str() + equals + 1, &value_end);
    if (end != line.c_str() + equals || *value_end || value_end == line.c_str() + equals + 1)
      out_ += "error:2\r\n";
    else if (!settings_.contains(static_cast<int>(number)))
      out_ += "error:3\r\n";
    else if (value < 0)
      out_ += "error:4\r\n";
    else if (state_ == State::kRun)
      out_ += "error:8\r\n";
    else if (number == 20 && value != 0 && settings_[22] == 0)
      out_ += "error:10\r\n";
    else {
      settings_[static_cast<int>(number)] = value;
      answer("");
    }
  } else {
    out_ += "error:3\r\n";
  }
}

int GrblFirmware::gcode(const std::string& line, Nanoseconds now) {
  std::optional<int> motion;
  std::array<std::optional<double>, kAxes> words;
  std::optional<double> p;
  bool dwell = false, machine = false, offset = false;
  std::set<char> seen;
  for (const char* at = line.c_str(); *at;) {
    const char letter = *at++;
    if (letter < 'A' || letter > 'Z') return 1;
    char* end = nullptr;
    const double value = std::strtod(at, &end);
    if (end == at || !std::isfinite(value)) return 2;
    at = end;
    if (letter != 'G' && letter != 'M' && !seen.insert(letter).second) return 25;
    const int whole = static_cast<int>(std::floor(value));
    switch (letter) {
      case 'G':
        if (value != whole && value != 94) return 20;
        switch (whole) {
          case 0:
          case 1:
            if (motion) return 24;
            motion = whole;
            break;
          case 4:
            dwell = true;
            break;
          case 10:
            offset = true;
            break;
          case 20:
          case 21:
            inches_ = whole == 20;
            break;
          case 53:
            machine = true;
            break;
          case 17:
          case 40:
          case 49:
          case 54:
          case 80:
          case 94:
            break;
          case 90:
          case 91:
            absolute_ = whole == 90;
            break;
          default:
            return 20;
        }
        break;
      case 'M':
        if (whole != 2 && whole != 5 && whole != 9 && whole != 30) return 20;
        break;
      case 'X':
      case 'Y':
        words[letter == 'X' ? 0 : 1] = value;
        break;
      case 'F':
        if (value < 0) return 4;
        feed_ = inches_ ? value * 25.4 : value;
        break;
      case 'P':
        p = value;
        break;
      case 'L':
      case 'N':
      case 'S':
      case 'T':
        break;
      default:
        return 20;
    }
  }
  const double unit = inches_ ? 25.4 : 1;
  if (dwell) {
    if (!p || *p < 0) return 28;
    dwelling_ = true;
    dwell_until_ = in_move_ ? kNever : now + static_cast<Nanoseconds>(1e9 * *p);
    return 0;
  }
  if (offset) {
    for (std::size_t a = 0; a < kAxes; ++a)
      if (words[a]) offset_mm_[a] = *words[a] * unit;
    return 0;
  }
  if (!words[0] && !words[1]) return 0;
  if (motion.value_or(1) == 1 && feed_ <= 0) return 22;
  std::array<double, kAxes> target{};
  const auto& base = planned_.empty() ? (in_move_ ? move_.to : steps_) : planned_.back().to;
  for (int a = 0; a < kAxes; ++a) {
    const auto i = static_cast<std::size_t>(a);
    const double here = static_cast<double>(base[i]) / steps_per_mm(a);
    target[i] = !words[i]    ? here
                : !absolute_ ? here + *words[i] * unit
                             : *words[i] * unit + (machine ? 0 : offset_mm_[i]);
  }
  return plan(target, motion.value_or(1) == 0 ? 1e9 : feed_, now);
}

void GrblFirmware::alarm(int code, bool locked_up) {
  state_ = State::kAlarm;
  locked_up_ = locked_up;
  planned_.clear();
  dwelling_ = false;
  if (code == 3 || code == 6) homed_ = false;
  out_ += fmt::format("ALARM:{}\r\n", code);
  if (locked_up) out_ += "[MSG:Reset to continue]\r\n";
}

std::string GrblFirmware::status() const {
  const char* name = state_ == State::kIdle    ? "Idle"
                     : state_ == State::kRun   ? "Run"
                     : state_ == State::kHold  ? "Hold:0"
                     : state_ == State::kAlarm ? "Alarm"
                                               : "Home";
  const auto steps = steps_at(now_);
  std::string text =
      fmt::format("<{}|{}Pos:", name, static_cast<int>(settings_.at(10)) & 1 ? "M" : "W");
  for (int a = 0; a < kAxes; ++a) {
    const auto i = static_cast<std::size_t>(a);
    const double machine = static_cast<double>(steps[i]) / steps_per_mm(a);
    text += fmt::format("{:.3f},",
                        static_cast<int>(settings_.at(10)) & 1 ? machine : machine - offset_mm_[i]);
  }
  return text + fmt::format("0.000|FS:{:.0f},0>\r\n", state_ == State::kRun ? feed_ : 0);
}

}  // namespace wheatstone
