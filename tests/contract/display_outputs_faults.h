#pragma once

#include "tests/contract/fault_case.h"

namespace wheatstone {

using enum DeviceError::Kind;

/// "after": "gone", "closed" (there is no object), "ready" (the next call works).
inline constexpr FaultCase kXrandrFaults[] = {
    {"xrandr", "no server", "opening", kNotFound, "closed"},
    {"xrandr", "no such name", "opening", kNotFound, "closed"},
    {"xrandr", "server without RandR", "opening", kRefused, "closed"},
    {"xrandr", "stall", "enumerating", kTimeout, "ready"},
    {"xrandr", "stall", "neutralising", kTimeout, "ready"},
    {"xrandr", "server killed", "enumerating", kDisconnected, "gone"},
    {"xrandr", "server killed", "neutralising", kDisconnected, "gone"},
};

inline constexpr FaultCase kSimulatedOutputFaults[] = {
    {"simulated display outputs", "silence", "enumerating", kTimeout, "ready"},
    {"simulated display outputs", "table stays", "neutralising", kFault, "ready"},
    {"simulated display outputs", "clock step", "enumerating", kTimeout, "ready"},
    {"simulated display outputs", "unplugged", "enumerating", kDisconnected, "gone"},
};

}  // namespace wheatstone
