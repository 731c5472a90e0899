#include "rendering/metrics/flicker.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "rendering/metrics/comparable.h"
#include "rendering/metrics/pu21.h"

namespace wheatstone {
namespace {

/// Three samples a pixel.
cv::Mat1f encoded(const RgbImage& image) {
  cv::Mat1f out(image.height(), 3 * image.width());
  for (int r = 0; r < out.rows; ++r)
    pu21_encode(std::span(image.pixels[r]->val, static_cast<std::size_t>(out.cols)),
                std::span(out[r], static_cast<std::size_t>(out.cols)));
  return out;
}

}  // namespace

void FlickerMeter::add(const RgbImage& test, const RgbImage& reference) {
  detail::require_same_size(test, reference, nullptr);
  detail::require_valid_light(test, reference);
  if (frames_ > 0 && cv::Size(3 * test.width(), test.height()) != last_error_.size())
    throw ArgumentError(
        fmt::format("frame {} has {}x{} pixels, the first one {}x{}", frames_ + 1, test.width(),
                    test.height(), last_error_.cols / 3, last_error_.rows),
        "give all frames one size");
  const cv::Mat1f error = encoded(test) - encoded(reference);
  if (frames_ > 0)
    steps_pu_.push_back(cv::norm(error, last_error_, cv::NORM_L2) /
                        std::sqrt(static_cast<double>(error.total())));
  last_error_ = error;
  ++frames_;
}

double FlickerMeter::flicker_pu() const {
  if (steps_pu_.empty())
    throw ArgumentError(fmt::format("flicker of {} frames is not defined", frames_),
                        "give at least two frames");
  double sum = 0;
  for (const double step : steps_pu_) sum += step * step;
  return std::sqrt(sum / static_cast<double>(steps_pu_.size()));
}

}  // namespace wheatstone
