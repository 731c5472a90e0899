#pragma once
// Settings of the emulated camera, as Sony's bodies list them (reference still_camera.md).

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace wheatstone {

/// Exposure times of the body, in thirds of a stop: the numerator in the upper half, the
/// denominator in the lower one, both as on its dial ("1/250", "13/10").
std::vector<std::uint32_t> shutter_codes();
inline double seconds_of(std::uint32_t shutter_code) {
  return static_cast<double>(shutter_code >> 16) / (shutter_code & 0xffff);
}

struct PtpProperty {
  enum Type : std::uint16_t { kU8 = 2, kS16 = 3, kU16 = 4, kU32 = 6 };
  Type type = kU16;
  bool writable = false;
  std::uint32_t current = 0;
  std::vector<std::uint32_t> choices;  // empty: any

  std::size_t width() const { return type == kU8 ? 1 : type == kU32 ? 4 : 2; }
};

namespace ptp {
enum Property : std::uint16_t {
  kQuality = 0x5004,  // 0x10 raw
  kWhiteBalance = 0x5005,
  kAperture = 0x5007,  // x 100
  kFocusMode = 0x500a,
  kProgram = 0x500e,
  kCompensation = 0x5010,
  kDrive = 0x5013,
  kShutter = 0xd20d,
  kFocusFound = 0xd213,
  kObjectsWaiting = 0xd215,  // 0x8000 + n
  kBattery = 0xd218,
  kIso = 0xd21e,
  kStoreTo = 0xd222,
  kSettableShutter = 0xd229,
  kHalfPress = 0xd2c1,
  kFullPress = 0xd2c2
};
}  // namespace ptp

/// As the lab sets the body by hand: manual mode and focus, raw, ISO 100, f/8.
std::map<std::uint16_t, PtpProperty> camera_properties(bool settable_shutter);

/// The data of operation 0x9209.
std::vector<std::byte> property_list(const std::map<std::uint16_t, PtpProperty>&);

}  // namespace wheatstone
