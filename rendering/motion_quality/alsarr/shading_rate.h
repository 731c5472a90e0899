#pragma once
// The shading rates that graphics hardware offers, and maps of them over the tiles of a frame.
// Source: thesis (UCAM-CL-TR-977), chapter 6; the order is that of the released programs.

#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace wheatstone {

/// A frame is cut into tiles of 16 x 16 px from its first pixel on; each has one rate.
inline constexpr int kTileSize_px = 16;

/// One shade for every block of width x height px, blocks aligned with the tile.
struct ShadingRate {
  const char* name;
  int width_px, height_px;

  /// Shades per tile: the thesis's unit of cost and budget, 16 (4x4) to 256 (1x1).
  constexpr int cost_px() const { return kTileSize_px * kTileSize_px / (width_px * height_px); }
};

inline constexpr int kShadingRateCount = 7;
/// Rate index i = 1..7 stands for kShadingRates[i - 1].
inline constexpr std::array<ShadingRate, kShadingRateCount> kShadingRates = {{{"4x4", 4, 4},
                                                                              {"2x4", 2, 4},
                                                                              {"4x2", 4, 2},
                                                                              {"2x2", 2, 2},
                                                                              {"1x2", 1, 2},
                                                                              {"2x1", 2, 1},
                                                                              {"1x1", 1, 1}}};

/// "2x4" to 2; ArgumentError with the seven names otherwise.
int shading_rate_index(const std::string& name);

/// Rate index 1..7 of every tile.
struct ShadingRateMap {
  cv::Mat1b rate_index;  // [tile_y][tile_x]

  int tiles_x() const { return rate_index.cols; }
  int tiles_y() const { return rate_index.rows; }
  /// The rate of the tile under a pixel; pixels beyond the map have that of the nearest tile.
  const ShadingRate& at_pixel(int x_px, int y_px) const;
  /// Shades over all tiles: the sum of cost_px().
  std::int64_t cost_px() const;
};

/// Tiles are numbered column by column: number = tile_x * tiles_y + tile_y.
/// Errors: ArgumentError unless choice has tiles_x * tiles_y indices in 1..7.
ShadingRateMap shading_rate_map(const std::vector<std::uint8_t>& choice, int tiles_x, int tiles_y);

/// Errors: ArgumentError for an empty map, or an index outside 1..7 (the first place named).
void require_valid_rates(const ShadingRateMap&);

/// One float channel "rate" that holds the indices. Errors: FileError; ArgumentError as above.
void write_shading_rate_map(const std::filesystem::path&, const ShadingRateMap&);
/// Errors: FileError also for a value that is no index in 1..7 (the first place named).
ShadingRateMap read_shading_rate_map(const std::filesystem::path&);

}  // namespace wheatstone
