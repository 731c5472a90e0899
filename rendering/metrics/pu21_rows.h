#pragma once
// PU21 values (banding_glare) of a picture's rows. Internal to rendering/metrics.

#include <opencv2/core.hpp>

#include "rendering/metrics/pu21_table.h"

namespace wheatstone::detail {

/// What of a pixel is encoded: its luminance, or one of its channels.
class Pu21Source {
 public:
  static Pu21Source luminance() { return Pu21Source(-1); }
  static Pu21Source channel(int rgb) { return Pu21Source(rgb); }

  /// Returns whether the light that was read is valid; if not, the values are meaningless.
  bool encode(const cv::Vec3f* light_cd_m2, int count, float* pu21) const;

 private:
  explicit Pu21Source(int channel) : channel_(channel) {}
  int channel_;  // -1: luminance
  Simd simd_ = best_simd();
  const Pu21Table& table_ = pu21_table(Pu21Variant::kBandingGlare);
};

}  // namespace wheatstone::detail
