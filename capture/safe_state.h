#pragma once

#include "hardware/rig.h"

namespace wheatstone {

/// Stops the stage and darkens the box.
inline void make_safe(const Rig& rig) noexcept {
  rig.stage.stop();
  try {
    for (int i = 0; i < rig.markers.count(); ++i) rig.markers.set(i, false);
    rig.leds.set_all(0);
  } catch (...) {  // a dead light is dark enough; the first error is the one to report
  }
}

/// Leaves the rig safe, however the block ends.
class SafeAtExit {
 public:
  explicit SafeAtExit(const Rig& rig) : rig_(rig) {}
  ~SafeAtExit() { make_safe(rig_); }
  SafeAtExit(const SafeAtExit&) = delete;
  SafeAtExit& operator=(const SafeAtExit&) = delete;

 private:
  const Rig& rig_;
};

}  // namespace wheatstone
