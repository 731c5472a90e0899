#pragma once

#include "sim/world.h"

namespace wheatstone {

/// Sees the box under its light once: its irradiance is baked, and the threads of the libraries
/// beneath start, which stay.
inline void warm_up(const World& world = World("card", 0.02, 7)) {
  world.scene.radiance({{185, 130, 550}, {0, 0, -1}}, {1, 0});
}

}  // namespace wheatstone
