#include "hardware/led_mapping.h"

#include <fmt/format.h>

#include "core/error.h"

namespace wheatstone {

std::vector<int> places_on_wire(const LedMapping& m) {
  constexpr int kMost = 512;
  if (m.rows < 1 || m.columns < 1 || m.rows > kMost || m.columns > kMost)
    throw ArgumentError(fmt::format("{} x {} is no LED array", m.columns, m.rows),
                        fmt::format("use 1 to {} rows and columns", kMost));
  const bool back = m.corner.starts_with("back-"), left = m.corner.ends_with("-left");
  if (m.corner != std::string(back ? "back" : "front") + (left ? "-left" : "-right"))
    throw ArgumentError(fmt::format("'{}' is no corner of an LED array", m.corner),
                        "use back-left, back-right, front-left or front-right");
  std::vector<int> places;
  for (int row = 0; row < m.rows; ++row)
    for (int column = 0; column < m.columns; ++column) {
      const int y = back ? row : m.rows - 1 - row, x = left ? column : m.columns - 1 - column;
      const int line = m.along_rows ? y : x, length = m.along_rows ? m.columns : m.rows;
      const int forward = m.along_rows ? x : y;
      const bool backward = m.serpentine && line % 2 == 1;
      places.push_back(line * length + (backward ? length - 1 - forward : forward));
    }
  return places;
}

void require_gamma(const std::string& what, double gamma) {
  if (!(gamma >= kLeastLedGamma && gamma <= kMostLedGamma))
    throw ArgumentError(fmt::format("{} gamma {} of LEDs cannot be", what, gamma),
                        fmt::format("use {} to {}", kLeastLedGamma, kMostLedGamma));
}

void require_response(const std::array<double, 3>& gamma, double max_mean_drive) {
  for (const double g : gamma) require_gamma("response", g);
  if (!(max_mean_drive > 0 && max_mean_drive <= 1))
    throw ArgumentError(fmt::format("mean drive {} is no limit", max_mean_drive),
                        "use more than 0, at most 1");
}

}  // namespace wheatstone
