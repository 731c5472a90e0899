#pragma once

#include "tests/contract/fault_case.h"

namespace wheatstone {

using enum DeviceError::Kind;

/// "after": "closed" (there is no object), "gone" (all further frames are refused), "as before"
/// (still the frame before it), "dark". But for the first
/// two, the next frame shows once the fault is over.
inline constexpr FaultCase kFadecandyFaults[] = {
    {"fadecandy", "not there", "opening", kNotFound, "closed"},
    {"fadecandy", "unknown serial", "opening", kNotFound, "closed"},
    {"fadecandy", "two, and no serial", "opening", kNotFound, "closed"},
    {"fadecandy", "two with one serial", "opening", kNotFound, "closed"},
    {"fadecandy", "in use", "opening", kBusy, "closed"},
    {"fadecandy", "not permitted", "opening", kPermission, "closed"},
    {"fadecandy", "old firmware", "opening", kFault, "closed"},
    {"fadecandy", "silence", "opening", kTimeout, "closed"},
    {"fadecandy", "requests unanswered", "opening", kTimeout, "closed"},
    {"fadecandy", "stalls again and again", "opening", kFault, "closed"},
    {"fadecandy", "bus error", "opening", kFault, "closed"},
    {"fadecandy", "counter of two bytes", "opening", kProtocol, "closed"},
    {"fadecandy", "unplugged in the table", "opening", kDisconnected, "closed"},
    {"fadecandy", "silence", "lighting", kTimeout, "as before"},
    {"fadecandy", "requests unanswered", "lighting", kTimeout, "as before"},
    {"fadecandy", "late", "lighting", kTimeout, "as before"},
    {"fadecandy", "frame lost", "lighting", kTimeout, "as before"},
    {"fadecandy", "stalls again and again", "lighting", kFault, "as before"},
    {"fadecandy", "bus error", "lighting", kFault, "as before"},
    {"fadecandy", "counter of two bytes", "lighting", kProtocol, "as before"},
    {"fadecandy", "stops counting", "lighting", kFault, "as before"},
    {"fadecandy", "unplugged", "lighting", kDisconnected, "gone"},
    {"fadecandy", "unplugged in mid-frame", "lighting", kDisconnected, "gone"},
    {"fadecandy", "unplugged while waiting", "lighting", kDisconnected, "gone"},
    {"fadecandy", "switched off meanwhile", "lighting", kRefused, "dark"},
    {"fadecandy", "more light than allowed", "lighting", kOutOfRange, "as before"},
    {"fadecandy", "no time left", "lighting", kTimeout, "as before"},
};

inline constexpr FaultCase kE131Faults[] = {
    {"e131", "nobody listens", "opening", kNotFound, "closed"},
    {"e131", "another machine's address", "opening", kNotFound, "closed"},
    {"e131", "broadcast address", "opening", kPermission, "closed"},
    {"e131", "controller switched off", "lighting", kDisconnected, "gone"},
    {"e131", "controller switched off", "idle", kDisconnected, "gone"},
    {"e131", "no time left", "lighting", kTimeout, "as before"},
    {"e131", "more light than allowed", "lighting", kOutOfRange, "as before"},
};

inline constexpr FaultCase kSimulatedLedFaults[] = {
    {"simulated LEDs", "silence", "lighting", kTimeout, "as before"},
    {"simulated LEDs", "garbage", "lighting", kProtocol, "as before"},
    {"simulated LEDs", "refusal", "lighting", kRefused, "as before"},
    {"simulated LEDs", "clock step", "lighting", kTimeout, "as before"},
    {"simulated LEDs", "unplugged", "lighting", kDisconnected, "gone"},
};

}  // namespace wheatstone
