#include "rendering/motion_quality/alsarr/shading_rate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/exr.h"

namespace wheatstone {
namespace {

constexpr const char* kChannel = "rate";

std::string rate_names() {
  std::string out;
  for (const ShadingRate& rate : kShadingRates)
    out += (out.empty() ? "" : ", ") + std::string(rate.name);
  return out;
}

bool is_rate_index(double v) {
  return v >= 1 && v <= kShadingRateCount && v == std::floor(v);
}

}  // namespace

int shading_rate_index(const std::string& name) {
  for (int i = 0; i < kShadingRateCount; ++i)
    if (name == kShadingRates[i].name) return i + 1;
  throw ArgumentError("'" + name + "' is no shading rate", "use one of " + rate_names());
}

const ShadingRate& ShadingRateMap::at_pixel(int x_px, int y_px) const {
  const int x = std::clamp(x_px / kTileSize_px, 0, tiles_x() - 1);
  const int y = std::clamp(y_px / kTileSize_px, 0, tiles_y() - 1);
  return kShadingRates[rate_index(y, x) - 1];
}

std::int64_t ShadingRateMap::cost_px() const {
  std::int64_t sum = 0;
  for (const unsigned char index : rate_index) sum += kShadingRates[index - 1].cost_px();
  return sum;
}

ShadingRateMap shading_rate_map(const std::vector<std::uint8_t>& choice, int tiles_x, int tiles_y) {
  if (tiles_x < 1 || tiles_y < 1 ||
      choice.size() != static_cast<std::size_t>(tiles_x) * static_cast<std::size_t>(tiles_y))
    throw ArgumentError(fmt::format("{} rates for {}x{} tiles", choice.size(), tiles_x, tiles_y),
                        "give one rate for each tile");
  ShadingRateMap map{cv::Mat1b(tiles_y, tiles_x)};
  std::size_t tile = 0;
  for (int x = 0; x < tiles_x; ++x)
    for (int y = 0; y < tiles_y; ++y) map.rate_index(y, x) = choice[tile++];
  require_valid_rates(map);
  return map;
}

void require_valid_rates(const ShadingRateMap& map) {
  if (map.rate_index.empty()) throw ArgumentError("a shading-rate map without tiles", "give one");
  for (int y = 0; y < map.tiles_y(); ++y)
    for (int x = 0; x < map.tiles_x(); ++x)
      if (!is_rate_index(map.rate_index(y, x)))
        throw ArgumentError(fmt::format("tile ({}, {}) has rate index {}", x, y,
                                        static_cast<int>(map.rate_index(y, x))),
                            "use 1 to 7, for " + rate_names());
}

void write_shading_rate_map(const std::filesystem::path& path, const ShadingRateMap& map) {
  require_valid_rates(map);
  ScalarImage indices;
  map.rate_index.convertTo(indices.pixels, CV_32F);
  write_exr(path, indices, kChannel);
}

ShadingRateMap read_shading_rate_map(const std::filesystem::path& path) {
  for (const ExrView& view : read_exr_views(path)) {
    const auto channel = view.channels.find(kChannel);
    if (channel == view.channels.end()) continue;
    const cv::Mat1f& indices = channel->second.pixels;
    for (int y = 0; y < indices.rows; ++y)
      for (int x = 0; x < indices.cols; ++x)
        if (!is_rate_index(indices(y, x)))
          throw FileError(path, fmt::format("tile ({}, {}) has rate index {}", x, y, indices(y, x)),
                          "use 1 to 7, for " + rate_names());
    ShadingRateMap map;
    indices.convertTo(map.rate_index, CV_8U);
    return map;
  }
  throw FileError(path, fmt::format("has no channel '{}'", kChannel),
                  "give a shading-rate map, such as `wheatstone quality allocate` writes");
}

}  // namespace wheatstone
