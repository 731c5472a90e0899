#include "sim/wire/head_tracker_firmware.h"

#include "hardware/head_stream.h"

namespace wheatstone {

std::string HeadTrackerFirmware::run(Nanoseconds now) {
  std::string out;
  for (; next_event() <= now; ++sent_) {
    const Nanoseconds exposed = clock_ns_ + SwayingHead::exposed_ns(sent_);
    const HeadSample sample{serial_, first_number_ + sent_, exposed / 1000,
                            (exposed + kTrackerDelayNs) / 1000, head_.measured(sent_)};
    out += to_line(sample) + "\n";
  }
  return out;
}

}  // namespace wheatstone
