#include "display/depth_filtering.h"

#include <cmath>
#include <string>

#include "core/error.h"

namespace wheatstone {

std::vector<double> plane_weights(std::span<const Vergence> planes, Vergence point) {
  if (planes.empty())
    throw ArgumentError("no focal planes given", "name at least one plane distance");
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (!std::isfinite(planes[i].value()) || (i > 0 && !(planes[i] < planes[i - 1])))
      throw ArgumentError(
          "focal plane " + std::to_string(i) + " is not farther than the one before",
          "list distinct planes from near to far");
  }
  if (!std::isfinite(point.value()))
    throw ArgumentError("the vergence of a point is not a number", "check its distance");

  std::vector<double> weights(planes.size(), 0.0);
  if (point >= planes.front()) {
    weights.front() = 1;
  } else if (point <= planes.back()) {
    weights.back() = 1;
  } else {
    std::size_t k = 0;
    while (point < planes[k + 1]) ++k;
    weights[k] = (point - planes[k + 1]) / (planes[k] - planes[k + 1]);
    weights[k + 1] = 1 - weights[k];
  }
  return weights;
}

RgbImage weighted(const RgbImage& light_cd_m2, const ScalarImage& weight) {
  if (light_cd_m2.pixels.size() != weight.pixels.size())
    throw ArgumentError("the weights and the image differ in size", "render both at one size");
  require_valid_radiance(light_cd_m2, "the light of a focal plane");
  RgbImage out(light_cd_m2.width(), light_cd_m2.height());
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const float w = weight.pixels(y, x);
      if (!(w >= 0 && w <= 1))
        throw ArgumentError("plane weight " + std::to_string(w) + " at (" + std::to_string(x) +
                                ", " + std::to_string(y) + ") is outside 0..1",
                            "compute weights with plane_weights");
      out.pixels(y, x) = light_cd_m2.pixels(y, x) * w;
    }
  }
  return out;
}

RgbImage weighted(const RgbImage& light_cd_m2, double weight) {
  return weighted(light_cd_m2, ScalarImage(light_cd_m2.width(), light_cd_m2.height(),
                                           static_cast<float>(weight)));
}

PlanePair split_by_depth(const RgbImage& light_cd_m2, const ScalarImage& weight_near) {
  PlanePair pair;
  pair.near_cd_m2 = weighted(light_cd_m2, weight_near);
  // The remainder, not (1 - w) times the light: both planes then add up to it exactly.
  pair.far_cd_m2.pixels = light_cd_m2.pixels - pair.near_cd_m2.pixels;
  return pair;
}

double lateral_misalignment_rad(Length eye_shift, Length near_plane, Length far_plane) {
  return eye_shift / near_plane - eye_shift / far_plane;
}

double axial_relative_magnification(Length eye_shift, Length near_plane, Length far_plane) {
  if (!(eye_shift < near_plane) || !(eye_shift < far_plane))
    throw ArgumentError("the eye shift reaches a focal plane", "give a shift below the distance");
  return near_plane / (near_plane - eye_shift) / (far_plane / (far_plane - eye_shift)) - 1;
}

}  // namespace wheatstone
