#pragma once

#include <string>

#include "sim/wire/hid/hid_firmware.h"
#include "sim/world.h"

namespace wheatstone {

/// A USB relay board as reference calibration_leds.md describes it, with the twin's marker LEDs on
/// its channels. Reports have no numbers. Orders to channels that it lacks are taken and change
/// nothing. Its power comes with its cable: all is off when it is made, and when it goes.
class RelayFirmware final : public HidFirmware {
 public:
  RelayFirmware(World&, std::string name = "BITFT", int channels = 4);
  ~RelayFirmware() override { go_dark(); }

  HidAbout about() const override;
  void lose_power() override { go_dark(); }
  const std::string& name() const { return name_; }

  std::uint8_t stuck = 0;  // channels whose relay does not move, nor says that it did

 private:
  int take(std::uint8_t number, std::string_view bytes, Nanoseconds now) override;
  int give(std::uint8_t number, std::string& bytes, Nanoseconds now) override;
  void go_dark();
  void light(std::uint8_t wanted);

  World& world_;
  std::string name_;
  int channels_;
  std::uint8_t on_ = 0;
};

}  // namespace wheatstone
