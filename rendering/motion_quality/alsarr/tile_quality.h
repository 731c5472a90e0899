#pragma once
// The quality of each tile at each of the seven shading rates.
// Source: thesis (UCAM-CL-TR-977), section 6.3; the separable form of the released programs
// (reference motion_quality.md, section 4, "Tile quality").

#include <vector>

#include "rendering/motion_quality/alsarr/quality_polynomial.h"
#include "rendering/motion_quality/alsarr/tile_buffers.h"

namespace wheatstone {

/// quality at m x n = (qx + qy) / 2 + 0.1: qx is the polynomial for the x speed at the rate 1/m
/// (0 for m = 4), qy that for the y speed at 1/n. The 0.1 keeps quality per cost from being 0.
inline constexpr double kTileQualityOffset = 0.1;

/// The polynomials of a scene at one refresh rate, arranged for the tiles of a frame.
class TileQualityModel {
 public:
  /// Errors: ArgumentError unless refresh_hz is positive and finite and the table has a material.
  TileQualityModel(const PolynomialTable&, double refresh_hz);

  /// quality[tile * 7 + rate index - 1]; tiles are numbered column by column (shading_rate.h).
  /// Errors: ArgumentError of require_valid(TileBuffers), or naming the tile whose material is not
  /// in the table.
  std::vector<double> evaluate(const TileBuffers&) const;

 private:
  /// One polynomial at the refresh rate: (s0 + s1 v + s2 v^2) (l3 l^3 + l2 l^2 + l1 l + l0).
  struct AtRefresh {
    double s0, s1, s2, l3, l2, l1, l0;
  };
  struct Row {
    AtRefresh half, full;
  };
  static AtRefresh at_refresh(const QualityPolynomial&, double refresh_hz);

  int materials_ = 0;
  std::vector<Row> rows_;  // [material][mip level]
};

}  // namespace wheatstone
