#include "rendering/motion_quality/gl/tile_reduction.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"
#include "rendering/motion_quality/alsarr/shading_rate.h"

namespace wheatstone {
namespace {

/// The most frequent material of the tile's samples, and its finest mip level.
cv::Vec2i dominant_material(const cv::Mat2i& material_mip, const cv::Point& first) {
  std::array<cv::Vec2i, 16> samples;
  for (int i = 0; i < 16; ++i)
    samples[i] = material_mip(std::min(first.y + 2 + 4 * (i / 4), material_mip.rows - 1),
                              std::min(first.x + 2 + 4 * (i % 4), material_mip.cols - 1));
  int most = 0;
  cv::Vec2i out;
  for (const cv::Vec2i& candidate : samples) {
    int count = 0, mip = candidate[1];
    for (const cv::Vec2i& sample : samples)
      if (sample[0] == candidate[0]) {
        ++count;
        mip = std::min(mip, sample[1]);
      }
    if (count > most) {
      most = count;
      out = {candidate[0], mip};
    }
  }
  return out;
}

}  // namespace

void require_valid(const PixelBuffers& b) {
  if (b.motion_px.empty()) throw ArgumentError("pixel buffers without pixels", "give a frame's");
  if (b.material_mip.size() != b.motion_px.size() ||
      b.light_cd_m2.pixels.size() != b.motion_px.size())
    throw ArgumentError(
        fmt::format("motion has {}x{} px, materials {}x{}, light {}x{}", b.motion_px.cols,
                    b.motion_px.rows, b.material_mip.cols, b.material_mip.rows,
                    b.light_cd_m2.width(), b.light_cd_m2.height()),
        "give all buffers of one frame the same size");
  for (int y = 0; y < b.motion_px.rows; ++y)
    for (int x = 0; x < b.motion_px.cols; ++x) {
      const cv::Vec2f& motion = b.motion_px(y, x);
      if (!std::isfinite(motion[0]) || !std::isfinite(motion[1]))
        throw ArgumentError(fmt::format("the motion of pixel ({}, {}) is not finite", x, y),
                            "give 0 where nothing is known");
      if (b.material_mip(y, x)[0] < 0 || b.material_mip(y, x)[1] < 0)
        throw ArgumentError(fmt::format("pixel ({}, {}) has a negative index", x, y),
                            "count materials and mip levels from 0");
    }
  require_valid_radiance(b.light_cd_m2, "the frame before");
}

TileBuffers reduce_to_tiles(const PixelBuffers& b, const FrameGeometry& geometry) {
  require_valid(b);
  require_valid(geometry);
  const cv::Size size = tile_count(b.motion_px.cols, b.motion_px.rows);
  TileBuffers out{cv::Mat1d(size), cv::Mat1d(size), cv::Mat1i(size), cv::Mat1i(size),
                  tile_luminance_cd_m2(b.light_cd_m2)};
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const cv::Point first(x * kTileSize_px, y * kTileSize_px);
      const cv::Mat2f tile = b.motion_px(cv::Rect(first, cv::Size(kTileSize_px, kTileSize_px)) &
                                         cv::Rect({}, b.motion_px.size()));
      cv::Vec2d sum;
      for (const cv::Vec2f& motion : tile)
        sum += cv::Vec2d(std::abs(motion[0]), std::abs(motion[1]));
      const double scale = geometry.refresh_hz / geometry.ppd / static_cast<double>(tile.total());
      out.speed_x_deg_per_s(y, x) = sum[0] * scale;
      out.speed_y_deg_per_s(y, x) = sum[1] * scale;
      const cv::Vec2i material = dominant_material(b.material_mip, first);
      out.material(y, x) = material[0];
      out.mip_level(y, x) = material[1];
    }
  return out;
}

}  // namespace wheatstone
