#pragma once

#include "tests/contract/fault_case.h"

namespace wheatstone {

using enum DeviceError::Kind;

/// "after": "gone", "closed" (there is no object), "ready" (the next recording works).
inline constexpr FaultCase kPhotodiodeFaults[] = {
    {"photodiode", "not there", "opening", kNotFound, "closed"},
    {"photodiode", "in use", "opening", kBusy, "closed"},
    {"photodiode", "no serial line", "opening", kFault, "closed"},
    {"photodiode", "silence", "opening", kTimeout, "closed"},
    {"photodiode", "garbage", "opening", kTimeout, "closed"},
    {"photodiode", "another device", "opening", kProtocol, "closed"},
    {"photodiode", "another protocol", "opening", kProtocol, "closed"},
    {"photodiode", "another serial", "opening", kFault, "closed"},
    {"photodiode", "rate of nothing", "opening", kFault, "closed"},
    {"photodiode", "rate that is none", "opening", kProtocol, "closed"},
    {"photodiode", "too long", "asked", kOutOfRange, "ready"},
    {"photodiode", "refusal", "asked", kRefused, "ready"},
    {"photodiode", "answer to an earlier question", "asked", kProtocol, "ready"},
    {"photodiode", "silence", "asked", kTimeout, "ready"},
    {"photodiode", "garbage", "asked", kProtocol, "ready"},
    {"photodiode", "over-long line", "asked", kProtocol, "ready"},
    {"photodiode", "not ASCII", "asked", kProtocol, "ready"},
    {"photodiode", "unplugged", "asked", kDisconnected, "gone"},
    {"photodiode", "lost block", "recording", kFault, "ready"},
    {"photodiode", "stall", "recording", kTimeout, "ready"},
    {"photodiode", "half a block", "recording", kTimeout, "ready"},
    {"photodiode", "flipped bit", "recording", kProtocol, "ready"},
    {"photodiode", "too many samples", "recording", kProtocol, "ready"},
    {"photodiode", "clock step", "recording", kFault, "ready"},
    {"photodiode", "clock set back", "recording", kFault, "ready"},
    {"photodiode", "saturated", "recording", kTooBright, "ready"},
    {"photodiode", "unplugged", "recording", kDisconnected, "gone"},
};

inline constexpr FaultCase kSimulatedLightSensorFaults[] = {
    {"simulated light sensor", "silence", "asked", kTimeout, "ready"},
    {"simulated light sensor", "lost samples", "asked", kFault, "ready"},
    {"simulated light sensor", "saturated", "recording", kTooBright, "ready"},
    {"simulated light sensor", "clock step", "asked", kTimeout, "ready"},
    {"simulated light sensor", "unplugged", "asked", kDisconnected, "gone"},
};

}  // namespace wheatstone
