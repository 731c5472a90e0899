#pragma once
// What a JETI specbos sends over its serial line (docs/hardware/jeti.md).

#include <optional>
#include <string>

#include "hardware/device_error.h"

namespace wheatstone {

/// One piece of an answer: a control byte, or a line of text without its end (CR).
struct JetiToken {
  enum class Kind { kAck, kNak, kBell, kText };
  Kind kind = Kind::kText;
  std::string text;
};

/// Takes the first whole token from the front of `bytes`; nothing if there is none yet. ENQ, which
/// may stand anywhere, and line feeds are dropped. `what` names the device in errors.
/// Throws DeviceError kProtocol for text without end; `bytes` is then empty.
std::optional<JetiToken> take_token(const std::string& what, std::string& bytes);

/// The number after `label` and a colon ("laser: 0"), whatever the case. Throws kProtocol if there
/// is none, or none that is finite.
double jeti_number(const std::string& what, const std::string& line, const std::string& label);

/// A line that is one number and nothing else.
std::optional<double> jeti_value(const std::string& line);

/// What `*stat:err?` says after a command was not accepted.
class JetiRefusal : public DeviceError {
 public:
  JetiRefusal(Kind kind, const std::string& problem, const std::string& remedy, int code)
      : DeviceError(kind, problem, remedy), code_(code) {}
  int code() const { return code_; }

 private:
  int code_;
};

/// The error with this number, as it concerns the caller. `what` was asked for `command`.
JetiRefusal jeti_error(const std::string& what, const std::string& command, int code);

inline constexpr int kJetiAborted = 147, kJetiUnknownCommand = 4, kJetiBeyondCalibration = 141;

}  // namespace wheatstone
