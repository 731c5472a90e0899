#include "hardware/hid/blink1.h"

#include <fmt/format.h>

#include "core/error.h"

namespace wheatstone {
namespace {

using Kind = DeviceError::Kind;

constexpr std::uint16_t kVendor = 0x27b8, kProduct = 0x01ed;
constexpr Blink1Colour kBlack = {0, 0, 0};

/// The only one with this serial.
std::filesystem::path find(const Blink1Settings& settings) {
  if (settings.serial.empty() || settings.colour == kBlack)
    throw ArgumentError("a blink(1) has no serial, or black for its colour",
                        "give the serial that `wheatstone doctor` lists, and a colour");
  std::vector<std::filesystem::path> found;
  for (const HidFound& d : list_hid_devices(kVendor, kProduct))
    if (d.serial == settings.serial) found.push_back(d.node);
  if (found.size() == 1) return found.front();
  if (found.empty())
    throw DeviceError(Kind::kNotFound,
                      fmt::format("no blink(1) has the serial '{}'", printable(settings.serial)),
                      "plug it in, or correct its serial in the rig file");
  throw DeviceError(Kind::kNotFound,
                    fmt::format("the blink(1) on {} and on {} both have the serial '{}'",
                                found[0].string(), found[1].string(), settings.serial),
                    "unplug one of them");
}

template <class Parse>
auto ask(HidDevice& device, const std::string& question, const Parse& parse,
         const Deadline& deadline) {
  device.send_feature(question, deadline);
  const std::string bytes = device.get_feature(kBlink1Report, kBlink1Bytes, deadline);
  const auto answer = parse(bytes);
  if (!answer)
    throw DeviceError(
        Kind::kProtocol,
        fmt::format("{} did not answer what it was asked ({})", device.what(), hex_of(bytes)),
        "end other programs that use it, or unplug it and plug it in again");
  return *answer;
}

DeviceIdentity identify(HidDevice& device, const std::string& serial, const Deadline& deadline) {
  return {"blink1", "blink(1)", serial,
          ask(device, blink1_version_question(), parse_blink1_version, deadline),
          device.node().string()};
}

std::string text(const Blink1Colour& c) {
  return fmt::format("({}, {}, {})", c[0], c[1], c[2]);
}

}  // namespace

std::vector<Blink1Found> list_blink1() {
  std::vector<Blink1Found> out;
  for (const HidFound& d : list_hid_devices(kVendor, kProduct)) {
    Blink1Found found{d.node, d.serial, std::nullopt};
    try {
      HidDevice("the blink(1) on " + d.node.string(), d.node, HidDevice::Use::kOwn);
    } catch (const DeviceError& e) {
      found.trouble = e;
    }
    out.push_back(std::move(found));
  }
  return out;
}

Blink1::Blink1(const Blink1Settings& settings, const Deadline& deadline)
    : Blink1(std::make_unique<HidDevice>("blink(1) " + settings.serial, find(settings),
                                         HidDevice::Use::kOwn, settings.transcript),
             settings, deadline) {}

Blink1::Blink1(std::unique_ptr<HidDevice> opened, const Blink1Settings& settings,
               const Deadline& deadline)
    : HidLights(std::move(opened), {{}, 1, {}, blink1_order(kBlack)}), colour_(settings.colour) {
  set_identity(identify(device(), settings.serial, deadline));
  set(0, deadline);
}

void Blink1::write(Mask wanted, const Deadline& deadline) {
  device().send_feature(blink1_order(wanted ? colour_ : kBlack), deadline);
}

MarkerLights::Mask Blink1::read(const Deadline& deadline) {
  const auto shown = [&](int led) {
    return ask(device(), blink1_colour_question(led), parse_blink1_colour, deadline);
  };
  const Blink1Colour first = shown(1), second = shown(2);
  if (first != second || (first != kBlack && first != colour_))
    throw DeviceError(Kind::kFault,
                      fmt::format("{} shows {} and {} where it was to show {} or nothing",
                                  device().what(), text(first), text(second), text(colour_)),
                      "end other programs that use it");
  return first == colour_ ? 1 : 0;
}

}  // namespace wheatstone
