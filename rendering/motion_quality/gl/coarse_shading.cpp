#include "rendering/motion_quality/gl/coarse_shading.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.h"

namespace wheatstone {
namespace {

/// Calls shade_block(block) for every block of the map, cut off at the picture's edge.
template <class ShadeBlock>
void for_each_block(const cv::Size& size, const ShadingRateMap& map,
                    const ShadeBlock& shade_block) {
  const cv::Rect picture({}, size);
  for (int tile_y = 0; tile_y < size.height; tile_y += kTileSize_px)
    for (int tile_x = 0; tile_x < size.width; tile_x += kTileSize_px) {
      const ShadingRate& rate = map.at_pixel(tile_x, tile_y);
      const cv::Rect tile = cv::Rect(tile_x, tile_y, kTileSize_px, kTileSize_px) & picture;
      for (int y = tile.y; y < tile.br().y; y += rate.height_px)
        for (int x = tile.x; x < tile.br().x; x += rate.width_px)
          shade_block(cv::Rect(x, y, rate.width_px, rate.height_px) & picture,
                      shading_point(rate, x, y));
    }
}

cv::Vec3f bilinear(const cv::Mat3f& image, const cv::Point2d& p) {
  const double x = std::clamp(p.x, 0.0, image.cols - 1.0);
  const double y = std::clamp(p.y, 0.0, image.rows - 1.0);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, image.cols - 1), y1 = std::min(y0 + 1, image.rows - 1);
  const auto u = static_cast<float>(x - x0), v = static_cast<float>(y - y0);
  return (1 - v) * ((1 - u) * image(y0, x0) + u * image(y0, x1)) +
         v * ((1 - u) * image(y1, x0) + u * image(y1, x1));
}

}  // namespace

cv::Point2d shading_point(const ShadingRate& rate, int x_px, int y_px) {
  const int x = x_px / rate.width_px * rate.width_px, y = y_px / rate.height_px * rate.height_px;
  return {x + 0.5 * (rate.width_px - 1), y + 0.5 * (rate.height_px - 1)};
}

CoarseShading shade_coarsely(
    const cv::Mat1i& surface, const ShadingRateMap& map,
    const std::function<cv::Vec3f(int surface, const cv::Point2d& point)>& shade) {
  if (surface.empty()) throw ArgumentError("a picture without pixels", "give one");
  require_valid_rates(map);
  CoarseShading out{RgbImage(surface.cols, surface.rows), 0};
  for_each_block(surface.size(), map, [&](const cv::Rect& block, const cv::Point2d& point) {
    std::map<int, cv::Vec3f> shaded;  // by surface
    for (int y = block.y; y < block.br().y; ++y)
      for (int x = block.x; x < block.br().x; ++x) {
        const auto [known, is_new] = shaded.try_emplace(surface(y, x));
        if (is_new) {
          known->second = shade(surface(y, x), point);
          ++out.shades;
        }
        out.light_cd_m2.pixels(y, x) = known->second;
      }
  });
  return out;
}

RgbImage shade_picture_coarsely(const RgbImage& picture, const ShadingRateMap& map) {
  return shade_coarsely(cv::Mat1i::zeros(picture.pixels.size()), map,
                        [&](int, const cv::Point2d& p) { return bilinear(picture.pixels, p); })
      .light_cd_m2;
}

}  // namespace wheatstone
