#pragma once

#include "tests/contract/fault_case.h"

namespace wheatstone {

using enum DeviceError::Kind;

/// "after": "gone", "closed" (there is no object), "ready" (the next measurement works).
inline constexpr FaultCase kJetiFaults[] = {
    {"jeti", "not there", "opening", kNotFound, "closed"},
    {"jeti", "in use", "opening", kBusy, "closed"},
    {"jeti", "no serial line", "opening", kFault, "closed"},
    {"jeti", "silence", "opening", kTimeout, "closed"},
    {"jeti", "not ASCII", "opening", kProtocol, "closed"},
    {"jeti", "over-long line", "opening", kProtocol, "closed"},
    {"jeti", "another device", "opening", kProtocol, "closed"},
    {"jeti", "another serial", "opening", kFault, "closed"},
    {"jeti", "impossible wavelengths", "opening", kFault, "closed"},
    {"jeti", "refuses everything", "opening", kProtocol, "closed"},
    {"jeti", "too long", "configuring", kOutOfRange, "ready"},
    {"jeti", "silence", "configuring", kTimeout, "ready"},
    {"jeti", "not ASCII", "configuring", kProtocol, "ready"},
    {"jeti", "answer to an earlier command", "configuring", kProtocol, "ready"},
    {"jeti", "unplugged", "configuring", kDisconnected, "gone"},
    {"jeti", "light stays on", "aiming", kFault, "ready"},
    {"jeti", "silence", "aiming", kTimeout, "ready"},
    {"jeti", "unplugged", "aiming", kDisconnected, "gone"},
    {"jeti", "overexposed", "measuring", kTooBright, "ready"},
    {"jeti", "underexposed", "measuring", kTooDark, "ready"},
    {"jeti", "error 123", "measuring", kRefused, "ready"},
    {"jeti", "error 160", "measuring", kRefused, "ready"},
    {"jeti", "error 131", "measuring", kFault, "ready"},
    {"jeti", "error 200", "measuring", kFault, "ready"},
    {"jeti", "error 999", "measuring", kFault, "ready"},
    {"jeti", "diffuser on", "measuring", kNotReady, "ready"},
    {"jeti", "stall", "measuring", kTimeout, "ready"},
    {"jeti", "silence", "measuring", kTimeout, "ready"},
    {"jeti", "garbage", "measuring", kProtocol, "ready"},
    {"jeti", "half an answer", "measuring", kTimeout, "ready"},
    {"jeti", "half a spectrum", "measuring", kProtocol, "ready"},
    {"jeti", "over-long line", "measuring", kProtocol, "ready"},
    {"jeti", "lost lines", "measuring", kProtocol, "ready"},
    {"jeti", "another luminance", "measuring", kFault, "ready"},
    {"jeti", "unplugged", "idle", kDisconnected, "gone"},
    {"jeti", "unplugged", "measuring", kDisconnected, "gone"},
};

inline constexpr FaultCase kSpotreadFaults[] = {
    {"spotread", "no such program", "opening", kNotFound, "closed"},
    {"spotread", "may not be run", "opening", kNotFound, "closed"},
    {"spotread", "another integration", "configuring", kOutOfRange, "ready"},
    {"spotread", "no light of its own", "aiming", kRefused, "ready"},
    {"spotread", "hangs", "measuring", kTimeout, "ready"},
    {"spotread", "hangs with a child", "measuring", kTimeout, "ready"},
    {"spotread", "ends with 1", "measuring", kRefused, "ready"},
    {"spotread", "killed", "measuring", kRefused, "ready"},
    {"spotread", "no XYZ", "measuring", kProtocol, "ready"},
    {"spotread", "XYZ that is none", "measuring", kProtocol, "ready"},
    {"spotread", "no spectrum", "measuring", kRefused, "ready"},
    {"spotread", "half a spectrum", "measuring", kProtocol, "ready"},
    {"spotread", "spectrum of two readings", "measuring", kProtocol, "ready"},
    {"spotread", "spectrum without norm", "measuring", kProtocol, "ready"},
    {"spotread", "not ASCII", "measuring", kProtocol, "ready"},
    {"spotread", "output without end", "measuring", kProtocol, "ready"},
    {"spotread", "another luminance", "measuring", kFault, "ready"},
    {"spotread", "program removed", "measuring", kNotFound, "ready"},
};

inline constexpr FaultCase kSimulatedMeterFaults[] = {
    {"simulated spectroradiometer", "silence", "measuring", kTimeout, "ready"},
    {"simulated spectroradiometer", "another luminance", "measuring", kFault, "ready"},
    {"simulated spectroradiometer", "overexposed", "measuring", kTooBright, "ready"},
    {"simulated spectroradiometer", "underexposed", "measuring", kTooDark, "ready"},
    {"simulated spectroradiometer", "not enough time", "measuring", kTimeout, "ready"},
    {"simulated spectroradiometer", "clock step", "measuring", kTimeout, "ready"},
    {"simulated spectroradiometer", "unplugged", "measuring", kDisconnected, "gone"},
};

}  // namespace wheatstone
