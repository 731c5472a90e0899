#include "sim/wire/led_ceiling.h"

#include <cmath>

namespace wheatstone {

void LedCeiling::drive(std::span<const Rgb> wire) {
  double sum = 0;
  for (std::size_t i = 0; i < light_.size(); ++i) {
    const auto place = static_cast<std::size_t>(place_of_led_[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      if (place < wire.size()) light_[i][c] = std::pow(wire[place][c], response_gamma_[c]);
      sum += light_[i][c];
    }
  }
  const std::lock_guard lock(world_.mutex);
  world_.light.led_drive = light_.empty() ? 0 : sum / (3 * static_cast<double>(light_.size()));
}

}  // namespace wheatstone
