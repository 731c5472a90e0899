#pragma once
// Random shading-rate maps and pictures.

#include "core/image.h"
#include "core/random.h"
#include "rendering/motion_quality/alsarr/shading_rate.h"

namespace wheatstone::testing {

inline ShadingRateMap random_map(int tiles_x, int tiles_y, std::uint64_t seed) {
  RandomStream random(seed, 0);
  ShadingRateMap map{cv::Mat1b(tiles_y, tiles_x)};
  for (unsigned char& index : map.rate_index)
    index = static_cast<unsigned char>(1 + random.next() % kShadingRateCount);
  return map;
}

inline RgbImage random_picture(int width, int height, std::uint64_t seed) {
  RandomStream random(seed, 1);
  RgbImage image(width, height);
  for (cv::Vec3f& p : image.pixels)
    for (int k = 0; k < 3; ++k) p[k] = static_cast<float>(1000 * random.uniform());
  return image;
}

}  // namespace wheatstone::testing
