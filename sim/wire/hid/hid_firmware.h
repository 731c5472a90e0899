#pragma once

#include <cerrno>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "core/clock.h"

namespace wheatstone {

/// What a HID device says of itself when it is plugged in.
struct HidAbout {
  std::uint16_t vendor = 0, product = 0;
  std::string manufacturer, product_name, serial;  // empty: it has none
  std::string report_descriptor;
};

/// What the processor of a HID device does, without the wire, in time that is handed in and never
/// goes back. Bytes are as they cross the bus: a report's number is their first byte if the device
/// numbers its reports. Not for two threads at once.
class HidFirmware {
 public:
  virtual ~HidFirmware() = default;
  virtual HidAbout about() const = 0;
  /// Its cable is pulled.
  virtual void lose_power() = 0;

  /// SET_REPORT and GET_REPORT; 0 or the errno that the kernel makes of the transfer's end.
  int set_report(std::uint8_t number, std::string bytes, Nanoseconds now) {
    if (spoil)
      if (const int error = spoil(false, bytes)) return error;
    return take(number, bytes, now);
  }
  int get_report(std::uint8_t number, std::string& bytes, Nanoseconds now) {
    const int error = give(number, bytes, now);
    return error || !spoil ? error : spoil(true, bytes);
  }

  /// Faults: changes what goes over the bus (`to_host`: towards it); returns the errno with which
  /// the transfer ends instead, or 0. Empty: none.
  std::function<int(bool to_host, std::string& bytes)> spoil;

 protected:
  virtual int take(std::uint8_t number, std::string_view bytes, Nanoseconds now) = 0;
  virtual int give(std::uint8_t number, std::string& bytes, Nanoseconds now) = 0;
};

}  // namespace wheatstone
