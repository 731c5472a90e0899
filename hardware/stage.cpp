#include "hardware/stage.h"

namespace wheatstone {

std::string to_string(StageState state) {
  switch (state) {
    case StageState::kUnknown:
      return "unknown";
    case StageState::kIdle:
      return "idle";
    case StageState::kMoving:
      return "moving";
    case StageState::kFault:
      return "fault";
  }
  throw InternalError("unknown state of a stage");
}

}  // namespace wheatstone
