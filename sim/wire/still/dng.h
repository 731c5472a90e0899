#pragma once
// Digital Negative, the camera raw file that an emulated camera hands over (Adobe DNG 1.4).

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/image.h"

namespace wheatstone {

struct DngPicture {
  MosaicImage mosaic;
  int black_dn = 0, white_dn = 0;
  std::uint32_t exposure_numerator = 1, exposure_denominator = 1;  // s
  int iso = 100;
  std::string make, model, serial;
};

/// The file: one uncompressed strip of 16-bit codes, little-endian. Pre: a mosaic that is not
/// empty.
std::vector<std::byte> dng_file(const DngPicture&);

}  // namespace wheatstone
