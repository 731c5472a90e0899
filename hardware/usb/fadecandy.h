#pragma once
// LED arrays on a Fadecandy controller (docs/hardware/fadecandy.md).

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hardware/led_array.h"
#include "hardware/led_mapping.h"
#include "hardware/usb/fadecandy_packets.h"
#include "hardware/usb/usb_device.h"

namespace wheatstone {

struct FadecandySettings {
  std::string usb_serial;  // empty: the only one there is
  LedMapping mapping;
  int leds_per_strand = 64;                          // strands are filled one after the other
  int strand_offset = 0;                             // LEDs before the array's first on each strand
  std::array<double, 3> response_gamma = {1, 1, 1};  // light = drive^gamma, of R, G, B
  double code_gamma = 2;     // spacing of the 255 steps of light: 1 even, more: finer in the dark
  bool dither = true;        // in time, finer than 8 bits; false: steady pulses
  bool interpolate = false;  // fade from frame to frame
  double max_mean_drive = 1;
};

/// Shows linear light in 255 steps: (n / 255)^code_gamma. Where the firmware counts frames, each is
/// confirmed. The LEDs keep their light when the controller loses its USB.
class Fadecandy final : public LedArray {
 public:
  /// Dark when it returns. Throws ArgumentError for settings that do not fit 8 strands of 64 LEDs;
  /// errors of UsbDevice; kFault for firmware older than 1.07; kTimeout.
  explicit Fadecandy(const FadecandySettings&);
  ~Fadecandy() override;

  DeviceIdentity identity() const override;
  int rows() const override { return settings_.mapping.rows; }
  int columns() const override { return settings_.mapping.columns; }
  /// Throws kTimeout if the frame is not confirmed; kFault if the controller stalls; kRefused if
  /// all_off() came meanwhile: it is dark then.
  void set_frame(const LedFrame&, Deadline) override;
  double max_mean_drive() const override { return settings_.max_mean_drive; }
  void all_off() noexcept override;

 private:
  std::optional<std::uint32_t> frames_received(const Deadline&);
  void wait_until_received(std::uint32_t frames_before, const Deadline&);

  const FadecandySettings settings_;
  const std::vector<int> pixel_of_led_;
  const std::vector<std::uint8_t> black_;
  UsbDevice usb_;
  bool counts_frames_ = false;
  std::atomic<std::uint32_t> switched_off_ = 0;  // how often
};

/// In place of an address where there is no serial.
inline constexpr const char* kOnlyFadecandy = "usb fadecandy";

std::vector<UsbFound> list_fadecandies();

/// For each LED, row by row, its pixel among the 512. Throws ArgumentError.
std::vector<int> fadecandy_pixels(const FadecandySettings&);

}  // namespace wheatstone
