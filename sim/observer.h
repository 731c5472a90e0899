#pragma once

#include <cstdint>

#include "hardware/alignment_observer.h"
#include "sim/world.h"

namespace wheatstone {

/// Aligns from the true eye centre, with isotropic Gaussian error of `noise_arcmin` per axis.
class SimulatedObserver final : public AlignmentObserver {
 public:
  SimulatedObserver(World& world, double noise_arcmin)
      : world_(world), noise_arcmin_(noise_arcmin) {}
  Eigen::Vector2d align(DisplayId id, const Eigen::Vector3d& p_rsb_mm, Deadline) override;

  /// Where the point truly falls on the display, without the observer's error.
  Eigen::Vector2d true_lcd_px(DisplayId id, const Eigen::Vector3d& p_rsb_mm) const;

 private:
  World& world_;
  double noise_arcmin_;
  std::uint64_t trial_ = 0;
};

}  // namespace wheatstone
