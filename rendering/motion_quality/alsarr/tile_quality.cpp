#include "rendering/motion_quality/alsarr/tile_quality.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "rendering/motion_quality/alsarr/shading_rate.h"

namespace wheatstone {

TileQualityModel::AtRefresh TileQualityModel::at_refresh(const QualityPolynomial& p, double f) {
  const auto& w = p.w;
  return {w[0] + w[2] * f + w[5] * f * f, w[1] + w[4] * f, w[3], w[6], w[7], w[8], w[9]};
}

TileQualityModel::TileQualityModel(const PolynomialTable& table, double refresh_hz)
    : materials_(table.materials()) {
  if (!(refresh_hz > 0) || !std::isfinite(refresh_hz))
    throw ArgumentError(fmt::format("the refresh rate is {} Hz", refresh_hz),
                        "give a positive number");
  if (materials_ == 0)
    throw ArgumentError("a polynomial table without materials", "give at least one");
  rows_.reserve(static_cast<std::size_t>(materials_) * kMipRows);
  for (int material = 0; material < materials_; ++material)
    for (int mip = 0; mip < kMipRows; ++mip) {
      const PolynomialTable::MipRow& row = table.at(material, mip);
      rows_.push_back({at_refresh(row[0], refresh_hz), at_refresh(row[1], refresh_hz)});
    }
}

std::vector<double> TileQualityModel::evaluate(const TileBuffers& buffers) const {
  require_valid(buffers);
  std::vector<double> quality(buffers.material.total() * kShadingRateCount);
  double* out = quality.data();
  for (int x = 0; x < buffers.tiles_x(); ++x)
    for (int y = 0; y < buffers.tiles_y(); ++y, out += kShadingRateCount) {
      const int material = buffers.material(y, x);
      if (material >= materials_)
        throw ArgumentError(
            fmt::format("tile ({}, {}) has material {}, the polynomial table has {}", x, y,
                        material, materials_),
            "give the table of this scene; materials count from 0");
      const Row& row = rows_[static_cast<std::size_t>(material) * kMipRows +
                             std::min(buffers.mip_level(y, x), kMipRows - 1)];
      const double l = std::log(buffers.luminance_cd_m2(y, x)) * (1 / std::numbers::ln10);
      const double vx = buffers.speed_x_deg_per_s(y, x), vy = buffers.speed_y_deg_per_s(y, x);
      // Half of each, because a tile's quality is the mean over both axes.
      const auto light = [&](const AtRefresh& p) {
        return 0.5 * (((p.l3 * l + p.l2) * l + p.l1) * l + p.l0);
      };
      const auto motion = [](const AtRefresh& p, double v) { return (p.s2 * v + p.s1) * v + p.s0; };
      const double half = light(row.half), full = light(row.full);
      const double hx = half * motion(row.half, vx), hy = half * motion(row.half, vy);
      const double fx = full * motion(row.full, vx), fy = full * motion(row.full, vy);
      // In the order of kShadingRates: 4x4, 2x4, 4x2, 2x2, 1x2, 2x1, 1x1.
      out[0] = kTileQualityOffset;
      out[1] = hx + kTileQualityOffset;
      out[2] = hy + kTileQualityOffset;
      out[3] = hx + hy + kTileQualityOffset;
      out[4] = fx + hy + kTileQualityOffset;
      out[5] = hx + fy + kTileQualityOffset;
      out[6] = fx + fy + kTileQualityOffset;
    }
  return quality;
}

}  // namespace wheatstone
