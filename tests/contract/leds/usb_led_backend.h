#pragma once

#include <memory>

#include "hardware/usb/fadecandy.h"
#include "sim/wire/usb/fadecandy_firmware.h"
#include "sim/wire/usb/usb_bus.h"
#include "tests/contract/leds/led_backends.h"
#include "tests/contract/mock_resources.h"

namespace wheatstone {

/// The emulated machine; it has threads of its own, which must not count as left behind.
inline MockBed& mock_bed() {
  static MockBed bed;
  return bed;
}

inline FadecandySettings odd_fadecandy() {
  FadecandySettings s;
  s.mapping = odd_mapping();
  s.leds_per_strand = 32;
  s.strand_offset = 3;
  s.response_gamma = {1.2, 1.2, 1.2};
  s.max_mean_drive = 0.75;
  return s;
}

class FadecandyBackend final : public LedBackend {
 public:
  explicit FadecandyBackend(const FadecandyFirmwareOptions& options = {})
      : LedBackend(led_world()), firmware_(ceiling_, options), peer_(mock_bed(), firmware_) {}
  LedArray& leds() override {
    if (!leds_) leds_ = std::make_unique<Fadecandy>(odd_fadecandy());
    return *leds_;
  }
  void close() override { leds_.reset(); }
  Clock& clock() override { return clock_; }
  void unplug() override { peer_.unplug(); }

  FadecandyFirmware& firmware() { return firmware_; }
  UsbDevicePeer& peer() { return peer_; }
  LedCeiling& ceiling() { return ceiling_; }

 private:
  SteadyClock clock_;
  LedCeiling ceiling_{world_, fadecandy_pixels(odd_fadecandy()), {1.2, 1.2, 1.2}};
  FadecandyFirmware firmware_;
  UsbDevicePeer peer_;
  std::unique_ptr<Fadecandy> leds_;
};

/// Starts the threads of libraries and of the emulation.
inline void warm_up_usb() {
  FadecandyBackend().leds();
  settle_handles();
}

}  // namespace wheatstone
