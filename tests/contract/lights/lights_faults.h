#pragma once

#include "tests/contract/fault_case.h"

namespace wheatstone {

using enum DeviceError::Kind;

/// "after": "closed" (there is no object), "dark" and "lit" as the device confirms once the fault
/// is over, "gone".
inline constexpr FaultCase kHidRelayFaults[] = {
    {"hid-relay", "not there", "opening", kNotFound, "closed"},
    {"hid-relay", "another name", "opening", kNotFound, "closed"},
    {"hid-relay", "two with one name", "opening", kNotFound, "closed"},
    {"hid-relay", "another product", "opening", kNotFound, "closed"},
    {"hid-relay", "in use", "opening", kBusy, "closed"},
    {"hid-relay", "not permitted", "opening", kPermission, "closed"},
    {"hid-relay", "silence", "opening", kTimeout, "closed"},
    {"hid-relay", "garbage", "opening", kProtocol, "closed"},
    {"hid-relay", "half a report", "opening", kProtocol, "closed"},
    {"hid-relay", "stalls", "opening", kRefused, "closed"},
    {"hid-relay", "stuck relay", "opening", kFault, "closed"},
    {"hid-relay", "unplugged in a transfer", "opening", kDisconnected, "closed"},
    {"hid-relay", "silence", "setting", kTimeout, "dark"},
    {"hid-relay", "late", "setting", kTimeout, "dark"},
    {"hid-relay", "garbage", "setting", kProtocol, "dark"},
    {"hid-relay", "half a report", "setting", kProtocol, "dark"},
    {"hid-relay", "stalls", "setting", kRefused, "dark"},
    {"hid-relay", "transfer error", "setting", kFault, "dark"},
    {"hid-relay", "order lost", "setting", kFault, "dark"},
    {"hid-relay", "stuck relay", "setting", kFault, "dark"},
    {"hid-relay", "another state", "setting", kFault, "dark"},
    {"hid-relay", "channels that it lacks", "setting", kProtocol, "dark"},
    {"hid-relay", "answers as another", "setting", kFault, "dark"},
    {"hid-relay", "switched off meanwhile", "setting", kRefused, "dark"},
    {"hid-relay", "unplugged", "setting", kDisconnected, "gone"},
    {"hid-relay", "unplugged in a transfer", "setting", kDisconnected, "gone"},
    {"hid-relay", "silence", "reading", kTimeout, "lit"},
    {"hid-relay", "late", "reading", kTimeout, "lit"},
    {"hid-relay", "garbage", "reading", kProtocol, "lit"},
    {"hid-relay", "half a report", "reading", kProtocol, "lit"},
    {"hid-relay", "stalls", "reading", kRefused, "lit"},
    {"hid-relay", "transfer error", "reading", kFault, "lit"},
    {"hid-relay", "channels that it lacks", "reading", kProtocol, "lit"},
    {"hid-relay", "answers as another", "reading", kFault, "lit"},
    {"hid-relay", "unplugged", "reading", kDisconnected, "gone"},
    {"hid-relay", "unplugged in a transfer", "reading", kDisconnected, "gone"},
};

inline constexpr FaultCase kBlink1Faults[] = {
    {"blink1", "not there", "opening", kNotFound, "closed"},
    {"blink1", "another name", "opening", kNotFound, "closed"},
    {"blink1", "two with one name", "opening", kNotFound, "closed"},
    {"blink1", "in use", "opening", kBusy, "closed"},
    {"blink1", "not permitted", "opening", kPermission, "closed"},
    {"blink1", "silence", "opening", kTimeout, "closed"},
    {"blink1", "garbage", "opening", kProtocol, "closed"},
    {"blink1", "half a report", "opening", kProtocol, "closed"},
    {"blink1", "no version", "opening", kProtocol, "closed"},
    {"blink1", "stalls", "opening", kRefused, "closed"},
    {"blink1", "unplugged in a transfer", "opening", kDisconnected, "closed"},
    {"blink1", "silence", "setting", kTimeout, "dark"},
    {"blink1", "late", "setting", kTimeout, "dark"},
    {"blink1", "garbage", "setting", kProtocol, "dark"},
    {"blink1", "half a report", "setting", kProtocol, "dark"},
    {"blink1", "answer to an earlier question", "setting", kProtocol, "dark"},
    {"blink1", "stalls", "setting", kRefused, "dark"},
    {"blink1", "transfer error", "setting", kFault, "dark"},
    {"blink1", "order lost", "setting", kFault, "dark"},
    {"blink1", "another colour", "setting", kFault, "dark"},
    {"blink1", "one LED broken", "setting", kFault, "dark"},
    {"blink1", "unplugged", "setting", kDisconnected, "gone"},
    {"blink1", "unplugged in a transfer", "setting", kDisconnected, "gone"},
    {"blink1", "silence", "reading", kTimeout, "lit"},
    {"blink1", "garbage", "reading", kProtocol, "lit"},
    {"blink1", "answer to an earlier question", "reading", kProtocol, "lit"},
    {"blink1", "another colour", "reading", kFault, "lit"},
    {"blink1", "stalls", "reading", kRefused, "lit"},
    {"blink1", "unplugged", "reading", kDisconnected, "gone"},
    {"blink1", "unplugged in a transfer", "reading", kDisconnected, "gone"},
};

inline constexpr FaultCase kSimulatedMarkersFaults[] = {
    {"simulated markers", "silence", "setting", kTimeout, "dark"},
    {"simulated markers", "garbage", "setting", kProtocol, "dark"},
    {"simulated markers", "refusal", "setting", kRefused, "dark"},
    {"simulated markers", "clock step", "setting", kTimeout, "dark"},
    {"simulated markers", "unplugged", "setting", kDisconnected, "gone"},
    {"simulated markers", "silence", "reading", kTimeout, "lit"},
    {"simulated markers", "garbage", "reading", kProtocol, "lit"},
    {"simulated markers", "unplugged", "reading", kDisconnected, "gone"},
};

}  // namespace wheatstone
