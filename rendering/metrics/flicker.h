#pragma once
// Flicker along a camera path: how much more (or less) a sequence changes from frame to frame than
// its reference does. A plain measure for comparing renderers, not a model of the visual system.

#include <optional>
#include <vector>

#include "core/image.h"

namespace wheatstone {

/// Frames of a test and of a reference sequence of the same camera path come in order; between
/// frames t-1 and t, with PU21 values x (test) and y (reference) of R, G and B (banding_glare),
///
///   step_t = sqrt( mean over pixels and channels of ((x_t - x_{t-1}) - (y_t - y_{t-1}))^2 ).
///
/// An error that stays where it is cancels; one that comes and goes does not. 0 for equal
/// sequences and for a constant error in PU21 units. Holds two frames, whatever the length.
class FlickerMeter {
 public:
  /// Errors: ArgumentError for sizes that differ between the two or from the first pair, and for
  /// NaN, infinite or negative light; the meter is then as before.
  void add(const RgbImage& test, const RgbImage& reference);

  int frames() const { return frames_; }
  /// Of each pair of neighbouring frames, in order. PU21 units.
  const std::vector<double>& steps_pu() const { return steps_pu_; }
  /// Root mean square of the steps. Errors: ArgumentError with fewer than two frames.
  double flicker_pu() const;

 private:
  int frames_ = 0;
  cv::Mat1f last_error_;  // x - y of the last frame, PU21 units, three samples a pixel
  std::vector<double> steps_pu_;
};

}  // namespace wheatstone
