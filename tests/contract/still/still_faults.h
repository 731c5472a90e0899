#pragma once

#include "tests/contract/fault_case.h"

namespace wheatstone {

inline constexpr FaultCase kGphotoFaults[] = {
    {"gphoto2", "not plugged in", "opening", DeviceError::Kind::kNotFound, "closed"},
    {"gphoto2", "another serial", "opening", DeviceError::Kind::kNotFound, "closed"},
    {"gphoto2", "another model", "opening", DeviceError::Kind::kNotFound, "closed"},
    {"gphoto2", "two of them, none named", "opening", DeviceError::Kind::kNotFound, "closed"},
    {"gphoto2", "wrong USB mode", "opening", DeviceError::Kind::kRefused, "closed"},
    {"gphoto2", "in use", "opening", DeviceError::Kind::kBusy, "closed"},
    {"gphoto2", "not permitted", "opening", DeviceError::Kind::kPermission, "closed"},
    {"gphoto2", "silence", "opening", DeviceError::Kind::kTimeout, "closed"},
    {"gphoto2", "garbage", "opening", DeviceError::Kind::kProtocol, "closed"},
    {"gphoto2", "half a description", "opening", DeviceError::Kind::kProtocol, "closed"},
    {"gphoto2", "session refused", "opening", DeviceError::Kind::kRefused, "closed"},
    {"gphoto2", "unplugged", "opening", DeviceError::Kind::kDisconnected, "closed"},
    {"gphoto2", "no exposure times", "opening", DeviceError::Kind::kRefused, "closed"},
    {"gphoto2", "no ISO 100", "opening", DeviceError::Kind::kRefused, "closed"},
    {"gphoto2", "no raw files", "opening", DeviceError::Kind::kRefused, "closed"},
    {"gphoto2", "ISO stays another", "opening", DeviceError::Kind::kRefused, "closed"},
    {"gphoto2", "silence", "idle", DeviceError::Kind::kTimeout, "ready"},
    {"gphoto2", "garbage", "idle", DeviceError::Kind::kProtocol, "ready"},
    {"gphoto2", "answer to another question", "idle", DeviceError::Kind::kProtocol, "ready"},
    {"gphoto2", "half an answer", "idle", DeviceError::Kind::kTimeout, "ready"},
    {"gphoto2", "endpoint halted for good", "idle", DeviceError::Kind::kProtocol, "ready"},
    {"gphoto2", "transmission errors", "idle", DeviceError::Kind::kProtocol, "ready"},
    {"gphoto2", "unplugged", "idle", DeviceError::Kind::kDisconnected, "gone"},
    {"gphoto2", "settings cannot be read", "idle", DeviceError::Kind::kRefused, "ready"},
    {"gphoto2", "exposure refused", "setting the exposure", DeviceError::Kind::kRefused, "ready"},
    {"gphoto2", "another exposure read back", "setting the exposure", DeviceError::Kind::kFault,
     "ready"},
    {"gphoto2", "exposure cannot be set any more", "setting the exposure",
     DeviceError::Kind::kRefused, "ready"},
    {"gphoto2", "card full", "triggering", DeviceError::Kind::kRefused, "ready"},
    {"gphoto2", "camera busy", "triggering", DeviceError::Kind::kRefused, "ready"},
    {"gphoto2", "button refused", "triggering", DeviceError::Kind::kRefused, "ready"},
    {"gphoto2", "silence", "triggering", DeviceError::Kind::kTimeout, "ready"},
    {"gphoto2", "unplugged", "triggering", DeviceError::Kind::kDisconnected, "gone"},
    {"gphoto2", "no picture comes", "exposing", DeviceError::Kind::kTimeout, "ready"},
    {"gphoto2", "longer than the deadline", "exposing", DeviceError::Kind::kTimeout, "ready"},
    {"gphoto2", "unplugged", "exposing", DeviceError::Kind::kDisconnected, "gone"},
    {"gphoto2", "picture refused", "fetching", DeviceError::Kind::kRefused, "ready"},
    {"gphoto2", "half a picture, then silence", "fetching", DeviceError::Kind::kTimeout, "ready"},
    {"gphoto2", "unplugged", "fetching", DeviceError::Kind::kDisconnected, "gone"},
    {"gphoto2", "file cut short", "fetching", DeviceError::Kind::kFault, "ready"},
    {"gphoto2", "file of zeros", "fetching", DeviceError::Kind::kFault, "ready"},
    {"gphoto2", "JPEG in place of raw", "fetching", DeviceError::Kind::kFault, "ready"},
    {"gphoto2", "other exposure in the file", "fetching", DeviceError::Kind::kFault, "ready"},
    {"gphoto2", "other ISO in the file", "fetching", DeviceError::Kind::kFault, "ready"},
    {"gphoto2", "power-cycle command fails", "after a time-out", DeviceError::Kind::kFault,
     "ready"},
    {"gphoto2", "power-cycle command hangs", "after a time-out", DeviceError::Kind::kTimeout,
     "ready"},
};

inline constexpr FaultCase kReplayFaults[] = {
    {"replay", "no folder", "opening", DeviceError::Kind::kNotFound, "closed"},
    {"replay", "empty folder", "opening", DeviceError::Kind::kNotFound, "closed"},
    {"replay", "damaged file", "exposing", DeviceError::Kind::kFault, "stays"},
    {"replay", "another exposure than recorded", "exposing", DeviceError::Kind::kOutOfRange,
     "ready"},
    {"replay", "no more files", "exposing", DeviceError::Kind::kNotReady, "stays"},
    {"replay", "folder taken away", "exposing", DeviceError::Kind::kDisconnected, "stays"},
};

inline constexpr FaultCase kSimulatedStillFaults[] = {
    {"simulated camera", "silence", "exposing", DeviceError::Kind::kTimeout, "ready"},
    {"simulated camera", "nonsense", "exposing", DeviceError::Kind::kProtocol, "ready"},
    {"simulated camera", "card full", "exposing", DeviceError::Kind::kRefused, "ready"},
    {"simulated camera", "damaged file", "exposing", DeviceError::Kind::kFault, "ready"},
    {"simulated camera", "clock step", "exposing", DeviceError::Kind::kTimeout, "ready"},
    {"simulated camera", "unplugged", "exposing", DeviceError::Kind::kDisconnected, "gone"},
};

}  // namespace wheatstone
