#pragma once
// What a GRBL 1.1 controller says, line by line (reference gantry_and_rotary.md, section 2).

#include <string>
#include <string_view>
#include <vector>

namespace wheatstone {

struct GrblMessage {
  enum class Type { kOk, kError, kAlarm, kStatus, kFeedback, kSetting, kBanner, kOther };
  Type type = Type::kOther;
  int number = 0;    // of kError, kAlarm, kSetting
  double value = 0;  // of kSetting
  std::string text;  // kStatus: the state; kFeedback: between the brackets; kBanner: version
  std::vector<double> mpos;  // of kStatus: machine position, if it is reported
};

/// Any bytes; what is not understood is kOther. `line` is without its end.
GrblMessage parse_grbl(std::string_view line);

/// "soft limits need homing" for 10, ...; "unknown" for numbers that GRBL 1.1 does not have.
std::string grbl_error_text(int number);
std::string grbl_alarm_text(int number);

}  // namespace wheatstone
