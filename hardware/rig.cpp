#include "hardware/rig.h"

namespace wheatstone {

void make_safe(const Rig& rig) noexcept {
  if (rig.stage) rig.stage->stop();
  if (rig.platform) rig.platform->stop();
  if (rig.markers) rig.markers->all_off();
  if (rig.leds) rig.leds->all_off();
  for (PanelOutput* panel : rig.panels)
    if (panel) panel->go_dark();
}

}  // namespace wheatstone
