#include "hardware/led_array.h"

#include <fmt/format.h>

namespace wheatstone {

double mean_drive(const LedFrame& frame) {
  double sum = 0;
  for (const cv::Vec3f& rgb : frame.drive)
    for (int c = 0; c < 3; ++c) sum += rgb[c];
  return frame.drive.empty() ? 0 : sum / (3.0 * static_cast<double>(frame.drive.total()));
}

void require_valid(const LedArray& leds, const LedFrame& frame) {
  const auto refuse = [](const std::string& problem, const std::string& remedy) {
    throw DeviceError(DeviceError::Kind::kOutOfRange, problem, remedy);
  };
  if (frame.drive.rows != leds.rows() || frame.drive.cols != leds.columns())
    refuse(fmt::format("a frame of {} x {} LEDs does not fit the array", frame.drive.cols,
                       frame.drive.rows),
           fmt::format("send {} x {}", leds.columns(), leds.rows()));
  for (int y = 0; y < frame.drive.rows; ++y)
    for (int x = 0; x < frame.drive.cols; ++x)
      for (int c = 0; c < 3; ++c)
        if (const float d = frame.drive(y, x)[c]; !(d >= 0 && d <= 1))
          refuse(fmt::format("drive {} of the LED in row {}, column {} is not in [0, 1]", d, y, x),
                 "use 0 for off and 1 for full light");
  if (const double mean = mean_drive(frame); mean > leds.max_mean_drive() + 1e-6)
    refuse(fmt::format("a frame with a mean drive of {:.3f} is more light than allowed", mean),
           fmt::format("stay below {:.3f}", leds.max_mean_drive()));
}

}  // namespace wheatstone
