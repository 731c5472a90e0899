#pragma once

#include <array>
#include <string>

#include "sim/wire/hid/hid_firmware.h"
#include "sim/world.h"

namespace wheatstone {

/// A blink(1) with two LEDs as reference calibration_leds.md describes it; both are the twin's
/// first marker LED, lit unless they are black. Knows the commands c, n, r and v of report 1; what
/// it does not know it leaves as it came.
class Blink1Firmware final : public HidFirmware {
 public:
  explicit Blink1Firmware(World&, std::string serial = "2A00CAFE");
  ~Blink1Firmware() override { go_dark(); }

  HidAbout about() const override;
  void lose_power() override { go_dark(); }

  std::string version = "24";
  bool first_led_broken = false;  // it stays black, and says so

 private:
  using Colour = std::array<double, 3>;
  struct Led {
    Colour from{}, to{};
    Nanoseconds start = 0, duration = 0;
  };

  int take(std::uint8_t number, std::string_view bytes, Nanoseconds now) override;
  int give(std::uint8_t number, std::string& bytes, Nanoseconds now) override;
  void go_dark();
  void fade(int led, const Colour& to, Nanoseconds duration, Nanoseconds now);
  Colour shown(std::size_t led, Nanoseconds now) const;
  void shine();

  World& world_;
  std::string serial_;
  std::array<Led, 2> leds_;
  std::string last_;  // the report that came last, which is the answer when it has been worked on
};

}  // namespace wheatstone
