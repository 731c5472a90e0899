#pragma once
// blink(1) as one marker light.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hardware/hid/blink1_report.h"
#include "hardware/hid/hid_lights.h"

namespace wheatstone {

struct Blink1Settings {
  std::string serial;  // its USB serial, eight hexadecimal digits
  Blink1Colour colour = {255, 255, 255};
  std::shared_ptr<Transcript> transcript;  // null: none
};

/// A blink(1) that is plugged in.
struct Blink1Found {
  std::filesystem::path node;
  std::string serial;
  std::optional<DeviceError> trouble;  // why it cannot be used
};
/// In the order of their nodes.
std::vector<Blink1Found> list_blink1();

/// One light: both LEDs in one colour. It is steady as soon as it says so.
class Blink1 final : public HidLights {
 public:
  /// Throws ArgumentError for settings without a serial, or a black colour; kNotFound, also if
  /// several have this serial; kBusy, kPermission, kProtocol, kFault. It is dark then.
  Blink1(const Blink1Settings&, const Deadline&);

 private:
  Blink1(std::unique_ptr<HidDevice>, const Blink1Settings&, const Deadline&);
  void write(Mask wanted, const Deadline&) override;
  Mask read(const Deadline&) override;

  Blink1Colour colour_;
};

}  // namespace wheatstone
