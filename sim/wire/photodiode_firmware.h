#pragma once

#include <cstdint>
#include <string>

#include "sim/light_sensor.h"
#include "sim/wire/serial_firmware.h"

namespace wheatstone {

/// The photodiode's microcontroller (docs/hardware/photodiode.md) over a PhotodiodeModel.
class PhotodiodeFirmware final : public SerialFirmware {
 public:
  PhotodiodeFirmware(World& world, DisplayId id, double gain = 1) : diode_(world, id, gain) {}

  void receive(std::string_view, Nanoseconds now) override;
  std::string run(Nanoseconds now) override;
  Nanoseconds next_event() const override;

  std::string identity = "PHOTODIODE/1 SIM-PHOTODIODE 10000";
  /// Its microseconds when it started; they wrap.
  std::uint32_t first_us = 0;

  // Faults.
  std::string refusal;       // answers RECORD with it
  bool refuse_time = false;  // answers TIME with the answer to an earlier one
  int lose_block = -1;       // this block of a recording is not sent
  int extra_samples = 0;     // more than asked for
  int stall_after = -1;      // no block after this one
  int step_clock_us = 0;     // its clock steps when it is to record

  bool recording() const { return sent_ < samples_.size(); }

 private:
  std::uint32_t us(Nanoseconds now) const {
    return first_us + static_cast<std::uint32_t>(now / 1000);
  }
  void command(const std::string&, Nanoseconds now);
  Nanoseconds block_done(std::size_t sent) const;

  PhotodiodeModel diode_;
  std::string line_, answers_;
  std::vector<std::uint16_t> samples_;
  std::size_t sent_ = 0;
  int block_ = 0;
  std::uint64_t recordings_ = 0;
  Nanoseconds start_ns_ = 0;
};

}  // namespace wheatstone
