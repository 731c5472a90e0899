#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/wire/led_ceiling.h"
#include "sim/wire/usb/usb_firmware.h"

namespace wheatstone {

struct FadecandyFirmwareOptions {
  std::string serial = "SIMFADECANDY0001";
  std::uint16_t version = 0x0107;
  std::string model = "Fadecandy";
  bool counts_frames = true;
  std::uint32_t first_frame = 0;  // of its counter
};

/// A Fadecandy: packets of 64 bytes in, 512 LEDs out. Frames show at once: it does not fade. The
/// LEDs keep their light when it is unplugged.
class FadecandyFirmware final : public UsbFirmware {
 public:
  FadecandyFirmware(LedCeiling& ceiling, const FadecandyFirmwareOptions& options = {})
      : ceiling_(ceiling), options_(options), frames_(options.first_frame) {}

  UsbDescription description() const override;
  UsbReply control(const UsbSetup&, std::span<const std::uint8_t>, Nanoseconds) override;
  UsbReply receive(std::uint8_t endpoint, std::span<const std::uint8_t>, Nanoseconds) override;
  Nanoseconds next_event() const override { return next_event_ns_; }

  std::uint8_t configuration() const { return configuration_; }
  std::uint32_t frames() const { return frames_; }

  // Faults.
  int stalls = 0;             // so many transfers to it stall
  int errors = 0;             // so many are lost on the wire
  bool silent = false;        // takes and answers nothing
  bool mute = false;          // answers no request
  bool loses_frames = false;  // takes packets and drops them
  int unplugs_after = -1;     // packets; -1: never
  std::size_t counter_bytes = 4;
  bool stops_counting = false;  // stalls requests for its counter
  Nanoseconds late_ns = 0;      // takes each transfer so much later

 private:
  void packet(std::span<const std::uint8_t>);
  void show();

  LedCeiling& ceiling_;
  const FadecandyFirmwareOptions options_;
  std::uint32_t frames_;
  std::uint8_t configuration_ = 0;
  std::array<std::uint8_t, 25 * 63> frame_{};
  std::array<std::uint16_t, 25 * 31> new_table_{}, table_{};
  Nanoseconds next_event_ns_ = kNever;
};

}  // namespace wheatstone
