#pragma once
// What the allocation knows about the frame to come, one value per tile of 16 x 16 px: motion,
// material, mip level, and the luminance of the frame before.
// Source: thesis (UCAM-CL-TR-977), section 6.3; reference motion_quality.md, section 4.

#include <filesystem>
#include <optional>

#include "core/image.h"

namespace wheatstone {

/// All of one size, [tile_y][tile_x].
struct TileBuffers {
  cv::Mat1d speed_x_deg_per_s, speed_y_deg_per_s;  // on the retina of a still eye; magnitudes
  cv::Mat1i material;                              // index into the polynomial table, from 0
  cv::Mat1i mip_level;                             // of the texture, >= 0
  cv::Mat1d luminance_cd_m2;  // mean over the tile plus kTileLuminanceOffset_cd_m2

  int tiles_x() const { return material.cols; }
  int tiles_y() const { return material.rows; }
  /// The tiles of a part of the frame. Errors: ArgumentError unless it lies inside.
  TileBuffers part(const cv::Rect& tiles) const;
};

/// Keeps the logarithm of a black tile finite.
inline constexpr double kTileLuminanceOffset_cd_m2 = 0.01;

/// Errors: ArgumentError for no tiles, sizes that differ, a speed that is negative or not finite, a
/// luminance that is not positive and finite, a negative index (the first tile named).
void require_valid(const TileBuffers&);

/// How pixels of motion become degrees per second.
struct FrameGeometry {
  int width_px = 1920, height_px = 1080;
  double refresh_hz = 60;
  double ppd = 60;  // pixels per degree of visual angle
};
/// Errors: ArgumentError naming what is not positive and finite.
void require_valid(const FrameGeometry&);

struct TileBufferFiles {
  std::filesystem::path motion;     // R, G: motion in x and y, per cent of the frame per refresh
  std::filesystem::path materials;  // R: material index, G: mip level
  std::optional<std::filesystem::path> luminance;  // Y: cd/m^2, used as it stands
  double uniform_luminance_cd_m2 = 100;            // where there is no luminance file
};
/// The sign of motion is dropped. Errors: FileError: not readable, a channel missing, no such
/// number (first tile named), a size other than that of the motion file; ArgumentError as above.
TileBuffers read_tile_buffers(const TileBufferFiles&, const FrameGeometry&);

/// Mean luminance of each tile plus the offset; tiles at the right and bottom may be partial.
/// Errors: ArgumentError for an empty or impossible image.
cv::Mat1d tile_luminance_cd_m2(const RgbImage&);

/// Number of tiles that cover a frame.
cv::Size tile_count(int width_px, int height_px);

}  // namespace wheatstone
