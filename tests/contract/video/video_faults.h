#pragma once

#include "tests/contract/fault_case.h"

namespace wheatstone {

using enum DeviceError::Kind;

/// "after": what the camera answers to a next call: "gone", "closed" (there is no object),
/// "stopped", "running".
inline constexpr FaultCase kV4l2Faults[] = {
    {"v4l2", "not there", "opening", kNotFound, "closed"},
    {"v4l2", "unknown serial", "opening", kNotFound, "closed"},
    {"v4l2", "two with one serial", "opening", kNotFound, "closed"},
    {"v4l2", "captures nothing", "opening", kNotFound, "closed"},
    {"v4l2", "no camera", "opening", kNotFound, "closed"},
    {"v4l2", "in use", "opening", kBusy, "closed"},
    {"v4l2", "not permitted", "opening", kPermission, "closed"},
    {"v4l2", "no streaming", "opening", kRefused, "closed"},
    {"v4l2", "lists without end", "listing", kProtocol, "stopped"},
    {"v4l2", "unplugged", "listing", kDisconnected, "gone"},
    {"v4l2", "unplugged", "configuring", kDisconnected, "gone"},
    {"v4l2", "in use", "configuring", kBusy, "stopped"},
    {"v4l2", "another format", "configuring", kFault, "stopped"},
    {"v4l2", "no size", "configuring", kProtocol, "stopped"},
    {"v4l2", "huge size", "configuring", kProtocol, "stopped"},
    {"v4l2", "short lines", "configuring", kProtocol, "stopped"},
    {"v4l2", "small buffers", "configuring", kProtocol, "stopped"},
    {"v4l2", "automatic exposure stays", "configuring", kFault, "stopped"},
    {"v4l2", "value out of range", "configuring", kOutOfRange, "stopped"},
    {"v4l2", "input or output error", "configuring", kFault, "stopped"},
    {"v4l2", "unplugged", "starting", kDisconnected, "gone"},
    {"v4l2", "in use", "starting", kBusy, "stopped"},
    {"v4l2", "no memory", "starting", kRefused, "stopped"},
    {"v4l2", "no buffers", "starting", kRefused, "stopped"},
    {"v4l2", "wrong offsets", "starting", kRefused, "stopped"},
    {"v4l2", "bus full", "starting", kRefused, "stopped"},
    {"v4l2", "unplugged", "running", kDisconnected, "gone"},
    {"v4l2", "unplugged while waiting", "running", kDisconnected, "gone"},
    {"v4l2", "silence", "running", kTimeout, "running"},
    {"v4l2", "ready and then not", "running", kTimeout, "running"},
    {"v4l2", "every frame damaged", "running", kTimeout, "running"},
    {"v4l2", "half frames", "running", kTimeout, "running"},
    {"v4l2", "empty frames", "running", kTimeout, "running"},
    {"v4l2", "input or output error", "running", kTimeout, "running"},
    {"v4l2", "unknown buffer", "running", kProtocol, "running"},
    {"v4l2", "garbage for a picture", "running", kTimeout, "running"},
    {"v4l2", "picture of another size", "running", kTimeout, "running"},
};

inline constexpr FaultCase kSimulatedVideoFaults[] = {
    {"simulated video camera", "silence", "listing", kTimeout, "stopped"},
    {"simulated video camera", "unplugged", "listing", kDisconnected, "gone"},
    {"simulated video camera", "refusal", "configuring", kRefused, "stopped"},
    {"simulated video camera", "unplugged", "configuring", kDisconnected, "gone"},
    {"simulated video camera", "refusal", "starting", kRefused, "stopped"},
    {"simulated video camera", "silence", "running", kTimeout, "running"},
    {"simulated video camera", "garbage", "running", kProtocol, "running"},
    {"simulated video camera", "clock step", "running", kTimeout, "running"},
    {"simulated video camera", "unplugged", "running", kDisconnected, "gone"},
};

}  // namespace wheatstone
