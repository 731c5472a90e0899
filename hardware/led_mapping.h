#pragma once
// How the LEDs of an array hang on their wire.

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

}  // namespace wheatstone
