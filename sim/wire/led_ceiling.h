#pragma once

#include <array>
#include <span>
#include <vector>

#include "sim/world.h"

namespace wheatstone {

/// The LEDs of the twin's box at the end of an emulated controller's wire. The box sees the mean of
/// their light, as with SimulatedLeds.
class LedCeiling {
 public:
  using Rgb = std::array<double, 3>;

  /// `place_of_led`: row by row, each LED's place on the wire. light = drive^response_gamma.
  LedCeiling(World& world, std::vector<int> place_of_led, Rgb response_gamma = {1, 1, 1})
      : world_(world),
        place_of_led_(std::move(place_of_led)),
        response_gamma_(response_gamma),
        light_(place_of_led_.size()) {}

  /// What drives each place on the wire, 0 to 1. LEDs beyond its end stay as they are.
  void drive(std::span<const Rgb> wire);
  /// The light of each LED, row by row.
  const std::vector<Rgb>& light() const { return light_; }

 private:
  World& world_;
  const std::vector<int> place_of_led_;
  const Rgb response_gamma_;
  std::vector<Rgb> light_;
};

}  // namespace wheatstone
