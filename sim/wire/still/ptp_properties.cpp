#include "sim/wire/still/ptp_properties.h"

#include "sim/wire/still/little_endian.h"

namespace wheatstone {
namespace {

void append_value(std::vector<std::byte>& out, const PtpProperty& p, std::uint32_t value) {
  if (p.width() == 1)
    append(out, static_cast<std::uint8_t>(value));
  else if (p.width() == 2)
    append(out, static_cast<std::uint16_t>(value));
  else
    append(out, value);
}

constexpr std::uint8_t kEnumeration = 2;

}  // namespace

std::vector<std::uint32_t> shutter_codes() {
  std::vector<std::uint32_t> codes;
  for (const std::uint32_t tenths :
       {300, 250, 200, 150, 130, 100, 80, 60, 50, 40, 32, 25, 20, 16, 13, 10, 8, 6, 5, 4})
    codes.push_back(tenths << 16 | 10);
  for (const std::uint32_t part :
       {3,   4,    5,    6,    8,    10,   13,   15,   20,   25,   30,  40,
        50,  60,   80,   100,  125,  160,  200,  250,  320,  400,  500, 640,
        800, 1000, 1250, 1600, 2000, 2500, 3200, 4000, 5000, 6400, 8000})
    codes.push_back(1U << 16 | part);
  return codes;
}

std::map<std::uint16_t, PtpProperty> camera_properties(bool settable_shutter) {
  using P = PtpProperty;
  constexpr std::uint32_t k60th = 1U << 16 | 60;
  std::map<std::uint16_t, PtpProperty> out = {
      {ptp::kQuality, {P::kU8, true, 0x10, {0x02, 0x03, 0x04, 0x10, 0x13}}},
      {ptp::kWhiteBalance, {P::kU16, true, 4, {2, 4, 5, 6, 7}}},
      {ptp::kAperture, {P::kU16, true, 800, {400, 450, 500, 560, 630, 710, 800, 900, 1000, 1100}}},
      {ptp::kFocusMode, {P::kU16, true, 1, {1, 2}}},
      {ptp::kProgram, {P::kU32, true, 1, {1, 2, 3, 4}}},
      {ptp::kCompensation, {P::kS16, false, 0, {}}},
      {ptp::kDrive, {P::kU32, true, 1, {1}}},
      {ptp::kShutter, {P::kU32, false, k60th, shutter_codes()}},
      {ptp::kFocusFound, {P::kU8, false, 1, {}}},
      {ptp::kObjectsWaiting, {P::kU16, false, 0, {}}},
      {ptp::kBattery, {P::kU8, false, 80, {}}},
      {ptp::kIso, {P::kU32, true, 100, {50, 64, 80, 100, 125, 160, 200, 400, 800, 1600}}},
      {ptp::kStoreTo, {P::kU16, true, 1, {1, 16, 17}}},
      {ptp::kHalfPress, {P::kU16, true, 1, {1, 2}}},
      {ptp::kFullPress, {P::kU16, true, 1, {1, 2}}},
  };
  if (settable_shutter) out[ptp::kSettableShutter] = {P::kU32, true, k60th, shutter_codes()};
  return out;
}

std::vector<std::byte> property_list(const std::map<std::uint16_t, PtpProperty>& properties) {
  std::vector<std::byte> out;
  append(out, static_cast<std::uint32_t>(properties.size()));
  append(out, std::uint32_t{0});
  for (const auto& [code, p] : properties) {
    append(out, code);
    append(out, static_cast<std::uint16_t>(p.type));
    append(out, static_cast<std::uint8_t>(p.writable));
    append(out, std::uint8_t{1});  // not greyed out
    append_value(out, p, 0);       // default
    append_value(out, p, p.current);
    append(out, p.choices.empty() ? std::uint8_t{0} : kEnumeration);
    if (p.choices.empty()) continue;
    append(out, static_cast<std::uint16_t>(p.choices.size()));
    for (const std::uint32_t choice : p.choices) append_value(out, p, choice);
  }
  return out;
}

}  // namespace wheatstone
