#pragma once

#include <span>
#include <vector>

#include "tests/contract/stage_faults.h"

namespace wheatstone {

/// Every table of faults, by driver.
inline std::vector<std::span<const FaultCase>> all_faults() {
  return {kGrblFaults, kArduinoGantryFaults, kSimulatedStageFaults};
}

}  // namespace wheatstone
