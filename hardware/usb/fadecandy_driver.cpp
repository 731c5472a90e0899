#include "hardware/usb/fadecandy_driver.h"

#include "hardware/rig_file/led_keys.h"
#include "hardware/usb/fadecandy.h"

namespace wheatstone {
namespace {

DevicePlan<LedArray> read_fadecandy(const TomlTable& table) {
  FadecandySettings s;
  s.usb_serial = table.text_or("usb_serial", "");
  s.mapping = read_led_mapping(table);
  s.leds_per_strand =
      static_cast<int>(table.integer_or("leds_per_strand", s.leds_per_strand, 1, kFadecandyStrand));
  s.strand_offset = static_cast<int>(table.integer_or("strand_offset", 0, 0, kFadecandyStrand - 1));
  if (table.has("response_gamma"))
    s.response_gamma = table.numbers<3>("response_gamma", kLeastLedGamma, kMostLedGamma);
  s.code_gamma = table.number_or("code_gamma", s.code_gamma, kLeastLedGamma, kMostLedGamma);
  s.dither = table.flag_or("dither", s.dither);
  s.interpolate = table.flag_or("interpolate", s.interpolate);
  s.max_mean_drive = table.number_or("max_mean_drive", s.max_mean_drive, 1e-3, 1);
  try {
    fadecandy_pixels(s);
  } catch (const ArgumentError& e) {
    table.fail("leds_per_strand", e.what());
  }
  return {"", s.usb_serial.empty() ? kOnlyFadecandy : "usb " + s.usb_serial, "",
          [s](RigContext&) -> std::unique_ptr<LedArray> { return std::make_unique<Fadecandy>(s); }};
}

}  // namespace

void add_fadecandy_driver(DriverCatalogue& catalogue) {
  catalogue.add<LedArray>("fadecandy", read_fadecandy);
}

}  // namespace wheatstone
