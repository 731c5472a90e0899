#include "hardware/serial/jeti_message.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <utility>

#include "hardware/transport/transcript.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr char kEnq = 5, kAck = 6, kBell = 7, kNak = 21;
constexpr std::size_t kLongestLine = 160;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

const char* meaning(int code) {
  switch (code) {
    case kJetiUnknownCommand:
      return "it does not know this command";
    case 7:
      return "a password is needed";
    case 120:
      return "overexposed";
    case 121:
      return "underexposed";
    case 123:
      return "its integration time found no rest";
    case 130:
      return "it has no shutter";
    case 131:
      return "it has no dark reading";
    case 132:
      return "it has no reference";
    case 140:
      return "its calibration is damaged";
    case kJetiBeyondCalibration:
      return "beyond its calibrated wavelengths";
    case kJetiAborted:
      return "aborted";
    case 160:
      return "no optical trigger";
    case 161:
      return "a wrong divider of the flicker";
    case 200:
      return "its memory is faulty";
    case 280:
      return "its battery is low";
    default:
      return code >= 8 && code <= 27 ? "a wrong argument" : "unknown error";
  }
}

}  // namespace

std::optional<JetiToken> take_token(const std::string& what, std::string& bytes) {
  std::erase_if(bytes, [](char c) { return c == kEnq || c == '\n'; });
  constexpr const char kEnds[] = {'\r', kAck, kBell, kNak};
  const std::size_t end = bytes.find_first_of(std::string_view(kEnds, sizeof kEnds));
  if (std::min(end, bytes.size()) > kLongestLine) {
    const std::string start = std::exchange(bytes, {});
    throw DeviceError(Kind::kProtocol,
                      fmt::format("{} sends lines without end ({})", what, hex_of(start)),
                      "check that this is the right device and its speed");
  }
  if (end == std::string::npos) return std::nullopt;
  JetiToken token;
  if (bytes[end] == '\r' || end > 0) {  // a control byte also ends a line
    token.text = bytes.substr(0, end);
    bytes.erase(0, bytes[end] == '\r' ? end + 1 : end);
    return token;
  }
  token.kind = bytes[0] == kAck    ? JetiToken::Kind::kAck
               : bytes[0] == kBell ? JetiToken::Kind::kBell
                                   : JetiToken::Kind::kNak;
  bytes.erase(0, 1);
  return token;
}

double jeti_number(const std::string& what, const std::string& line, const std::string& label) {
  const std::string text = lower(line), wanted = lower(label) + ":";
  if (const std::size_t at = text.find(wanted); at != std::string::npos) {
    std::size_t begin = at + wanted.size();
    while (begin < text.size() && text[begin] == ' ') ++begin;
    double value = 0;
    const auto [end, error] =
        std::from_chars(text.data() + begin, text.data() + text.size(), value);
    if (error == std::errc() && std::isfinite(value) &&
        (end == text.data() + text.size() || *end == ' '))
      return value;
  }
  throw DeviceError(
      Kind::kProtocol,
      fmt::format("{} does not answer with '{}: number' but: {}", what, label, printable(line)),
      "run the command again");
}

std::optional<double> jeti_value(const std::string& line) {
  const std::size_t begin = line.find_first_not_of(" \t");
  const std::size_t last = line.find_last_not_of(" \t");
  if (begin == std::string::npos) return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(line.data() + begin, line.data() + last + 1, value);
  if (error != std::errc() || end != line.data() + last + 1 || !std::isfinite(value))
    return std::nullopt;
  return value;
}

JetiRefusal jeti_error(const std::string& what, const std::string& command, int code) {
  const std::string problem =
      fmt::format("{} answers {} with error {}, {}", what, command, code, meaning(code));
  switch (code) {
    case 120:
      return {Kind::kTooBright, problem, "show less light", code};
    case 121:
      return {Kind::kTooDark, problem, "show more light, or integrate longer", code};
    case 123:
      return {Kind::kRefused, problem, "hold the light still, or give the period of its flicker",
              code};
    case 160:
    case 161:
      return {Kind::kRefused, problem, "check the period of the light's flicker", code};
    default:
      if (code < 100) return {Kind::kRefused, problem, "check its firmware", code};
      return {Kind::kFault, problem, "switch it off and on again; if it stays, have it serviced",
              code};
  }
}

}  // namespace wheatstone
