#pragma once
// What the set-up of an LED array says, whatever drives it: how its LEDs hang on their wire, how
// they answer, how much light they may give.

#include <array>
#include <string>
#include <vector>

namespace wheatstone {

/// One wire through all LEDs, line by line, cut into strands of equal length.
struct LedMapping {
  int rows = 16, columns = 16;
  std::string corner =
      "back-left";         // of the first LED: back|front-left|right, as LedArray's frames
  bool along_rows = true;  // a line is a row; else a column
  bool serpentine = true;  // every second line runs backwards
};

/// For each LED, row by row, its place on the wire, from 0. Throws ArgumentError for another corner
/// or sizes outside [1, 512].
std::vector<int> places_on_wire(const LedMapping&);

inline constexpr double kLeastLedGamma = 0.2, kMostLedGamma = 5;
/// Throws ArgumentError for an exponent outside of these; `what` it is of.
void require_gamma(const std::string& what, double gamma);

/// Throws ArgumentError for exponents of R, G, B that require_gamma() refuses, and for a limit of
/// the mean drive outside (0, 1].
void require_response(const std::array<double, 3>& gamma, double max_mean_drive);

}  // namespace wheatstone
