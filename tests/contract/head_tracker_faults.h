#pragma once

#include "tests/contract/fault_case.h"

namespace wheatstone {

using enum DeviceError::Kind;

/// "after": "gone", "closed" (there is no object), "running" (the next good sample is handed out).
inline constexpr FaultCase kSerialHeadTrackerFaults[] = {
    {"serial head tracker", "not there", "opening", kNotFound, "closed"},
    {"serial head tracker", "in use", "opening", kBusy, "closed"},
    {"serial head tracker", "no serial line", "opening", kFault, "closed"},
    {"serial head tracker", "silence", "running", kTimeout, "running"},
    {"serial head tracker", "half a line", "running", kTimeout, "running"},
    {"serial head tracker", "garbage", "running", kProtocol, "running"},
    {"serial head tracker", "over-long line", "running", kProtocol, "running"},
    {"serial head tracker", "not ASCII", "running", kProtocol, "running"},
    {"serial head tracker", "another version", "running", kProtocol, "running"},
    {"serial head tracker", "impossible place", "running", kProtocol, "running"},
    {"serial head tracker", "another tracker", "running", kFault, "running"},
    {"serial head tracker", "old samples", "running", kTimeout, "running"},
    {"serial head tracker", "unplugged", "running", kDisconnected, "gone"},
    {"serial head tracker", "unplugged while waiting", "running", kDisconnected, "gone"},
};

inline constexpr FaultCase kUdpHeadTrackerFaults[] = {
    {"UDP head tracker", "port in use", "opening", kBusy, "closed"},
    {"UDP head tracker", "address of another machine", "opening", kNotFound, "closed"},
    {"UDP head tracker", "silence", "running", kTimeout, "running"},
    {"UDP head tracker", "garbage", "running", kProtocol, "running"},
    {"UDP head tracker", "half a datagram", "running", kProtocol, "running"},
    {"UDP head tracker", "over-long line", "running", kProtocol, "running"},
    {"UDP head tracker", "not ASCII", "running", kProtocol, "running"},
    {"UDP head tracker", "another version", "running", kProtocol, "running"},
    {"UDP head tracker", "impossible place", "running", kProtocol, "running"},
    {"UDP head tracker", "another tracker", "running", kFault, "running"},
    {"UDP head tracker", "old samples", "running", kTimeout, "running"},
    {"UDP head tracker", "another sender", "running", kTimeout, "running"},
};

inline constexpr FaultCase kSimulatedHeadTrackerFaults[] = {
    {"simulated head tracker", "silence", "running", kTimeout, "running"},
    {"simulated head tracker", "garbage", "running", kProtocol, "running"},
    {"simulated head tracker", "clock step", "running", kTimeout, "running"},
    {"simulated head tracker", "unplugged", "running", kDisconnected, "gone"},
};

}  // namespace wheatstone
