#pragma once

#include <cstdint>
#include <string>

#include "sim/head_tracker.h"
#include "sim/wire/serial_firmware.h"

namespace wheatstone {

/// A head tracker that sends a line per sample and listens to nothing. Its clock starts with the
/// observer's; it looks at the same head as SimulatedHeadTracker does.
class HeadTrackerFirmware final : public SerialFirmware {
 public:
  explicit HeadTrackerFirmware(World& world, std::string serial = "SIM-TRACKER",
                               std::uint32_t first_number = 0)
      : head_(world.seed), serial_(std::move(serial)), first_number_(first_number) {}

  void receive(std::string_view, Nanoseconds) override {}
  std::string run(Nanoseconds now) override;
  Nanoseconds next_event() const override {
    return SwayingHead::exposed_ns(sent_) + kTrackerDelayNs;
  }

  /// Its clock is set back, or forward.
  void step_clock(Nanoseconds by) { clock_ns_ += by; }

 private:
  SwayingHead head_;
  std::string serial_;
  std::uint32_t first_number_;
  std::uint32_t sent_ = 0;
  Nanoseconds clock_ns_ = 1'000'000'000'000;  // at the start; it started long before
};

}  // namespace wheatstone
