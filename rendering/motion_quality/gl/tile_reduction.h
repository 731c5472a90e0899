#pragma once
// From the buffers that a renderer has for every pixel to those of the allocation, one per tile.
// Source: thesis (UCAM-CL-TR-977), section 6.3; reference motion_quality.md, section 4.

#include "core/image.h"
#include "rendering/motion_quality/alsarr/tile_buffers.h"

namespace wheatstone {

/// All of one size, [row][column].
struct PixelBuffers {
  cv::Mat2f motion_px;     // x and y, since the frame before; either sign
  cv::Mat2i material_mip;  // material index from 0, mip level from 0
  RgbImage light_cd_m2;    // of the frame before
};

/// Speed: the mean magnitude of each axis. Luminance: the mean plus kTileLuminanceOffset_cd_m2.
/// Material: the most frequent one of 16 samples, 4 px apart from (2, 2) on; among equally frequent
/// ones that whose sample comes first, row by row. Mip level: the finest of that material's
/// samples. Tiles at the right and bottom may be partial; samples beyond the frame are its edge's.
/// Of the geometry, refresh_hz and ppd count; the size is the buffers'.
/// Errors: ArgumentError for empty buffers, sizes that differ, motion or light that is not finite,
/// negative indices or light, an impossible geometry.
TileBuffers reduce_to_tiles(const PixelBuffers&, const FrameGeometry&);

/// The errors above.
void require_valid(const PixelBuffers&);

}  // namespace wheatstone
