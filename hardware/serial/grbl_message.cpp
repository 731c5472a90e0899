#include "hardware/serial/grbl_message.h"

#include <charconv>
#include <cmath>
#include <map>
#include <optional>

namespace wheatstone {
namespace {

template <class Number>
std::optional<Number> number_of(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<std::vector<double>> numbers_of(std::string_view list) {
  constexpr std::size_t kMostAxes = 6;
  std::vector<double> out;
  while (out.size() < kMostAxes) {
    const std::size_t comma = list.find(',');
    const auto value = number_of<double>(list.substr(0, comma));
    if (!value || !std::isfinite(*value)) return std::nullopt;
    out.push_back(*value);
    if (comma == std::string_view::npos) return out;
    list.remove_prefix(comma + 1);
  }
  return std::nullopt;
}

/// "<Idle|MPos:0.000,0.000,0.000|FS:0,0>" without its brackets.
GrblMessage parse_status(std::string_view text) {
  GrblMessage message;
  const std::size_t bar = text.find('|');
  const std::string_view state = text.substr(0, std::min(bar, text.find(':')));
  for (const char* known :
       {"Idle", "Run", "Hold", "Jog", "Alarm", "Door", "Check", "Home", "Sleep"})
    if (state == known) message.text = std::string(text.substr(0, bar));
  if (message.text.empty() || bar == std::string_view::npos) return {};
  for (std::string_view rest = text.substr(bar + 1);;) {
    const std::size_t end = rest.find('|');
    const std::string_view field = rest.substr(0, end);
    if (field.starts_with("MPos:")) {
      const auto numbers = numbers_of(field.substr(5));
      if (!numbers || !message.mpos.empty()) return {};
      message.mpos = *numbers;
    }
    if (end == std::string_view::npos) break;
    rest.remove_prefix(end + 1);
  }
  message.type = GrblMessage::Type::kStatus;
  return message;
}

}  // namespace

GrblMessage parse_grbl(std::string_view line) {
  using Type = GrblMessage::Type;
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
  while (!line.empty() && line.front() == '\r') line.remove_prefix(1);
  GrblMessage message;
  const auto numbered = [&](std::string_view prefix, Type type) {
    const auto number = number_of<int>(line.substr(prefix.size()));
    if (number && *number >= 0) {
      message.type = type;
      message.number = *number;
    }
    return message;
  };
  if (line == "ok") {
    message.type = Type::kOk;
    return message;
  }
  if (line.starts_with("error:")) return numbered("error:", Type::kError);
  if (line.starts_with("ALARM:")) return numbered("ALARM:", Type::kAlarm);
  if (line.size() > 2 && line.front() == '<' && line.back() == '>')
    return parse_status(line.substr(1, line.size() - 2));
  if (line.size() >= 2 && line.front() == '[' && line.back() == ']') {
    message.type = Type::kFeedback;
    message.text = std::string(line.substr(1, line.size() - 2));
    return message;
  }
  if (line.starts_with("Grbl ")) {
    message.type = Type::kBanner;
    message.text = std::string(line.substr(5, line.substr(5).find(' ')));
    return message;
  }
  if (const std::size_t equals = line.find('='); line.starts_with('$') && equals != line.npos) {
    const auto number = number_of<int>(line.substr(1, equals - 1));
    const auto value = number_of<double>(line.substr(equals + 1));
    if (number && *number >= 0 && value && std::isfinite(*value)) {
      message.type = Type::kSetting;
      message.number = *number;
      message.value = *value;
    }
  }
  return message;
}

std::string grbl_error_text(int number) {
  static const std::map<int, const char*> texts = {{1, "no letter"},
                                                   {2, "bad number"},
                                                   {3, "unknown $ command"},
                                                   {4, "negative value"},
                                                   {5, "homing is off"},
                                                   {7, "settings lost, defaults loaded"},
                                                   {8, "not idle"},
                                                   {9, "locked"},
                                                   {10, "soft limits need homing"},
                                                   {11, "line too long"},
                                                   {14, "line overflow"},
                                                   {15, "jog beyond travel"},
                                                   {16, "bad jog"},
                                                   {20, "unsupported code"},
                                                   {22, "no feed rate"},
                                                   {23, "integer needed"},
                                                   {24, "two codes of one group"},
                                                   {33, "bad target"}};
  const auto it = texts.find(number);
  return it == texts.end() ? "unknown" : it->second;
}

std::string grbl_alarm_text(int number) {
  static const std::map<int, const char*> texts = {
      {1, "a limit switch was hit, the position is lost"},
      {2, "target beyond the soft limits"},
      {3, "reset while moving, the position is lost"},
      {4, "probe in the wrong state"},
      {5, "probe found nothing"},
      {6, "reset during homing"},
      {7, "door opened during homing"},
      {8, "could not pull off the home switch"},
      {9, "home switch not found"}};
  const auto it = texts.find(number);
  return it == texts.end() ? "unknown" : it->second;
}

}  // namespace wheatstone
