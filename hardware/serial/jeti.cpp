#include "hardware/serial/jeti.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/colour.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr int kSpeeds[] = {921600, 115200, 38400};
constexpr std::string_view kEscape = "\x1b";
constexpr int kTries = 5;
constexpr std::size_t kHeaderLines = 2;
constexpr double kFallbackFirstNm = 380, kFallbackLastNm = 780;

/// The device's own name: the 1211 says JETI_SB1211, the 1201 SB05...
bool is_specbos(const std::string& name) {
  return name.starts_with("JETI_SB") || name.starts_with("SB05");
}

void require_address(const JetiSettings& s) {
  if (s.line.empty())
    throw ArgumentError("a spectroradiometer has no address", "name its link in /dev/serial/by-id");
}

Deadline sooner(const Deadline& deadline, Duration d) {
  Deadline soon = SteadyClock().in(d, deadline.cancel);
  soon.at_ns = std::min(soon.at_ns, deadline.at_ns);
  return soon;
}

}  // namespace

Jeti::Jeti(const JetiSettings& settings, std::shared_ptr<Transcript> transcript)
    : settings_(settings) {
  require_address(settings);
  find_speed(transcript);
  const Deadline soon = SteadyClock().in(4 * settings.answer);
  get_in_step(soon);
  identity_.firmware = firmware_version(soon);
  identity_.serial = fmt::format(
      "{:.0f}", jeti_number(port_->what(), query("*para:spnum?", soon), "spectrometer number"));
  if (!settings.serial.empty() && identity_.serial != settings.serial)
    throw DeviceError(Kind::kFault,
                      fmt::format("{} has the serial '{}' and not '{}'", port_->what(),
                                  identity_.serial, settings.serial),
                      "correct its serial or its address in the rig file");
  range_.floor_cd_m2 = settings.floor_cd_m2;
  set_up(soon);
}

std::string Jeti::firmware_version(const Deadline& deadline) {
  std::string version = printable(query("*vers?", deadline));
  // Old firmware goes on for another line; its name is asked for to see the end.
  send("*idn?", deadline);
  for (int more = 0;;) {
    const JetiToken token = next(deadline);
    if (token.kind == JetiToken::Kind::kText && token.text == identity_.model) return version;
    if (token.kind != JetiToken::Kind::kText || ++more > 3)
      throw DeviceError(Kind::kProtocol, port_->what() + " goes on about its version",
                        "run the command again");
    version += " " + printable(token.text);
  }
}

Jeti::~Jeti() {
  if (measuring_ || !in_step_) port_->write_now(kEscape);
  if (aiming_) port_->write_now("*contr:laser 0\r");
}

void Jeti::find_speed(const std::shared_ptr<Transcript>& transcript) {
  const std::string what = "the spectroradiometer at " + settings_.line.string();
  std::string heard;
  for (const int baud : kSpeeds) {
    if (settings_.baud != 0 && settings_.baud != baud) continue;
    port_.reset();  // before it is opened again
    port_ = std::make_unique<SerialPort>(what, settings_.line, baud, transcript);
    input_.clear();
    const Deadline soon = SteadyClock().in(settings_.answer);
    try {
      port_->write(kEscape, soon);  // a measurement of a program that was killed
      send("*idn?", soon);
      for (bool again = false;;) {  // what that program left unread comes first
        const JetiToken token = next(soon);
        if (token.kind == JetiToken::Kind::kNak && !again) {
          // It ended that measurement, or what was sent at another speed spoilt the question.
          again = true;
          send("*idn?", soon);
        }
        if (token.kind != JetiToken::Kind::kText || token.text.empty()) continue;
        heard = printable(token.text);
        if (!is_specbos(token.text)) continue;
        identity_ = {"jeti", heard, "", "", settings_.line.string()};
        in_step_ = !again;  // else its name may come once more
        return;
      }
    } catch (const DeviceError& e) {
      if (e.kind() != Kind::kTimeout && e.kind() != Kind::kProtocol) throw;
      if (e.kind() == Kind::kProtocol) heard = "lines without end";
    }
  }
  if (!port_)
    throw ArgumentError(fmt::format("a specbos does not speak at {} baud", settings_.baud),
                        "use 921600, 115200, 38400, or 0 to find out");
  if (!heard.empty())
    throw DeviceError(Kind::kProtocol,
                      fmt::format("{} does not say that it is a JETI specbos: {}", what, heard),
                      "check that this is the right device");
  throw DeviceError(Kind::kTimeout, what + " did not answer at any speed",
                    "check cable and power, then run the command again");
}

void Jeti::set_up(const Deadline& deadline) {
  exchange(deadline, [&] {
    for (const char* command : {"*conf:default", "*contr:laser 0", "*para:calibn 0", "*para:expo 1",
                                "*conf:func 6", "*conf:form 4"})
      set(command, deadline);
    const double first =
        jeti_number(port_->what(), query("*para:wavbeg?", deadline), "Predefined start wave");
    const double last =
        jeti_number(port_->what(), query("*para:wavend?", deadline), "Predefined end wave");
    if (!(first >= 200 && last <= 2000 && last - first >= 100))
      throw DeviceError(
          Kind::kFault,
          fmt::format("{} says that it measures from {} to {} nm", port_->what(), first, last),
          "check its firmware");
    range_.step_nm = 1;
    range_.longest_integration = Duration::of(60);
    set_range(std::ceil(first), std::floor(last), deadline);
    set("*conf:maxtin 60000", deadline);
    set("*conf:aver 1", deadline);
  });
}

void Jeti::set_range(double first_nm, double last_nm, const Deadline& deadline) {
  set(fmt::format("*conf:wran {:.0f} {:.0f} 1", first_nm, last_nm), deadline);
  range_.first_nm = first_nm;
  range_.last_nm = last_nm;
}

JetiToken Jeti::next(const Deadline& deadline) {
  for (;;) {
    if (std::optional<JetiToken> token = take_token(port_->what(), input_))
      return *std::move(token);
    input_ += port_->read(deadline);
  }
}

void Jeti::send(const std::string& command, const Deadline& deadline) {
  port_->write(command + "\r", deadline);
}

std::string Jeti::query(const std::string& command, const Deadline& deadline) {
  send(command, deadline);
  JetiToken token = next(deadline);
  if (token.kind == JetiToken::Kind::kNak) refused(command, deadline);
  if (token.kind != JetiToken::Kind::kText)
    throw DeviceError(Kind::kProtocol, port_->what() + " gives no answer to " + command,
                      "run the command again");
  return std::move(token.text);
}

void Jeti::set(const std::string& command, const Deadline& deadline) {
  send(command, deadline);
  const JetiToken token = next(deadline);
  if (token.kind == JetiToken::Kind::kNak) refused(command, deadline);
  if (token.kind != JetiToken::Kind::kAck)
    throw DeviceError(Kind::kProtocol,
                      fmt::format("{} does not accept {} but answers: {}", port_->what(), command,
                                  printable(token.text)),
                      "run the command again");
}

int Jeti::error_code(const Deadline& deadline) {
  send("*stat:err?", deadline);
  const double code = jeti_number(port_->what(), next(deadline).text, "Error Code");
  return static_cast<int>(std::clamp(code, 0.0, 9999.0));
}

void Jeti::refused(const std::string& command, const Deadline& deadline) {
  const int code = error_code(deadline);
  if (code == kJetiAborted) throw Cancelled(port_->what() + ": measurement aborted");
  throw jeti_error(port_->what(), command, code);
}

void Jeti::get_in_step(const Deadline& deadline) {
  if (in_step_) return;
  port_->write(kEscape, deadline);  // ends what may still run
  try {
    for (;;) next(sooner(deadline, settings_.quiet));
  } catch (const DeviceError& e) {
    if (e.kind() != Kind::kTimeout && e.kind() != Kind::kProtocol) throw;
  }
  port_->discard_input();
  input_.clear();
  if (query("*idn?", deadline) != identity_.model)
    throw DeviceError(Kind::kProtocol, port_->what() + " does not come to rest",
                      "switch it off and on again");
  in_step_ = true;
}

template <class Exchange>
void Jeti::exchange(const Deadline& deadline, const Exchange& run) {
  get_in_step(deadline);
  in_step_ = false;
  run();
  in_step_ = true;
}

void Jeti::configure(const Settings& settings, Deadline deadline) {
  require_valid(settings, range_.longest_integration);
  exchange(deadline, [&] {
    set(fmt::format("*conf:maxtin {:.0f}",
                    std::max(1.0, std::round(1e3 * settings.longest_integration.value()))),
        deadline);
    set(fmt::format("*conf:aver {}", settings.average), deadline);
    const double period_s = settings.synchronise_to.value();
    if (period_s > 0) set(fmt::format("*conf:cyctim {:.0f}", 1e6 * period_s), deadline);
    set(fmt::format("*conf:cycmod {}", period_s > 0 ? 1 : 0), deadline);
  });
}

void Jeti::aim(bool on, Deadline deadline) {
  exchange(deadline, [&] {
    aiming_ = true;  // until it says otherwise
    set(on ? "*contr:laser 1" : "*contr:laser 0", deadline);
    const double answer = jeti_number(port_->what(), query("*contr:laser?", deadline), "laser");
    aiming_ = answer != 0;
    if (aiming_ != on)
      throw DeviceError(
          Kind::kFault,
          fmt::format("the aiming light of {} stays {}", port_->what(), aiming_ ? "on" : "off"),
          "switch it off and on again");
  });
}

void Jeti::abort() noexcept {
  aborted_ = true;
  if (measuring_) port_->write_now(kEscape);
}

void Jeti::expose(const Deadline& deadline) {
  struct Running {  // not longer than this call
    Jeti& jeti;
    bool ended = false;
    ~Running() {
      jeti.measuring_ = false;
      if (!ended) jeti.port_->write_now(kEscape);
    }
  } running{*this};
  measuring_ = true;
  set("*init", deadline);
  if (aborted_) port_->write_now(kEscape);  // it may have been asked before it began
  const JetiToken token = next(deadline);
  running.ended = token.kind != JetiToken::Kind::kText;
  if (token.kind == JetiToken::Kind::kNak) refused("*init", deadline);
  if (token.kind != JetiToken::Kind::kBell)
    throw DeviceError(Kind::kProtocol,
                      fmt::format("{} does not say that it is done but: {}", port_->what(),
                                  printable(token.text)),
                      "run the command again");
}

std::vector<double> Jeti::fetch_values(const Deadline& deadline) {
  // Bytes may be lost on the way, so that only silence says that there are no more.
  send("*fetch:sprad", deadline);
  std::vector<double> values;
  const auto wanted = static_cast<std::size_t>(range_.last_nm - range_.first_nm) + 1;
  for (std::size_t line = 0; line < wanted + kHeaderLines; ++line) {
    JetiToken token;
    try {
      token = next(line == 0 ? deadline : sooner(deadline, settings_.quiet));
    } catch (const DeviceError& e) {
      if (line == 0 || e.kind() != Kind::kTimeout || SteadyClock().now_ns() >= deadline.at_ns)
        throw;
      return values;
    }
    if (token.kind == JetiToken::Kind::kNak) refused("*fetch:sprad", deadline);
    if (line < kHeaderLines) continue;
    // Two lines that lost the end between them are no number, as a rule.
    if (const std::optional<double> value = jeti_value(token.text)) values.push_back(*value);
  }
  return values;
}

SpectralRadiance Jeti::fetch_spectrum(const Deadline& deadline) {
  for (int attempt = 0; attempt < kTries; ++attempt) {
    const auto wanted = static_cast<std::size_t>(range_.last_nm - range_.first_nm) + 1;
    SpectralRadiance spectrum{range_.first_nm, range_.step_nm, fetch_values(deadline)};
    if (spectrum.values.size() == wanted) return spectrum;
    // The rest of a spectrum that came too long, or a line that was cut.
    port_->discard_input();
    input_.clear();
  }
  throw DeviceError(Kind::kProtocol,
                    fmt::format("{} lost parts of its spectrum {} times", port_->what(), kTries),
                    "use another USB port, without a hub, or an idle machine");
}

Eigen::Vector3d Jeti::fetch_xyz(const Deadline& deadline) {
  send("*fetch:XYZ", deadline);
  const JetiToken first = next(deadline);
  const std::string& what = port_->what();
  if (first.kind == JetiToken::Kind::kNak) {
    const int code = error_code(deadline);
    if (code != kJetiUnknownCommand) throw jeti_error(what, "*fetch:XYZ", code);
    // Some firmware has luminance and chromaticity only.
    const double Y = jeti_number(what, query("*fetch:photo", deadline), "Luminance[cd/m^2]");
    const std::string xy = query("*fetch:chromxy", deadline);
    const double x = jeti_number(what, xy, "Chrom_x"), y = jeti_number(what, xy, "Chrom_y");
    return y > 0 ? xyz_from_xyY({x, y}, Y) : Eigen::Vector3d(0, Y, 0);
  }
  Eigen::Vector3d xyz;
  xyz.x() = jeti_number(what, first.text, "X");
  xyz.y() = jeti_number(what, next(deadline).text, "Y");
  xyz.z() = jeti_number(what, next(deadline).text, "Z");
  return xyz;
}

SpectralReading Jeti::measure(Deadline deadline) {
  aborted_ = false;
  aim(false, deadline);
  try {
    SpectralReading reading;
    exchange(deadline, [&] {
      if (jeti_number(port_->what(), query("*contr:mhead?", deadline), "mhead") != 0)
        throw DeviceError(Kind::kNotReady, "the diffuser is on " + port_->what(),
                          "take it off: light is measured through the open lens");
      expose(deadline);
      try {
        reading.spectrum = fetch_spectrum(deadline);
      } catch (const JetiRefusal& e) {
        // Units calibrated by others know 380 to 780 nm only.
        if (e.code() != kJetiBeyondCalibration || range_.first_nm == kFallbackFirstNm) throw;
        set_range(kFallbackFirstNm, kFallbackLastNm, deadline);
        reading.spectrum = fetch_spectrum(deadline);
      }
      reading.xyz_cd_m2 = xyz_cd_m2(reading.spectrum);
      reading.device_xyz_cd_m2 = fetch_xyz(deadline);
      reading.below_floor = reading.xyz_cd_m2.y() < range_.floor_cd_m2;
      if (!reading.below_floor && !agree(reading.xyz_cd_m2, *reading.device_xyz_cd_m2))
        throw DeviceError(
            Kind::kFault,
            fmt::format("the spectrum of {} gives {:.6g} cd/m^2, itself it says {:.6g}",
                        port_->what(), reading.xyz_cd_m2.y(), reading.device_xyz_cd_m2->y()),
            "measure again; if it stays, check its calibration");
    });
    return reading;
  } catch (const DeviceError& e) {
    if (aborted_ && e.kind() != Kind::kDisconnected)
      throw Cancelled(port_->what() + ": measurement aborted");
    throw;
  }
}

}  // namespace wheatstone
