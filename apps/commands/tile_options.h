#pragma once
// The options of commands that allocate shading rates to the tiles of a frame.

#include <CLI/App.hpp>
#include <string>

#include "rendering/motion_quality/alsarr/rate_allocation.h"
#include "rendering/motion_quality/alsarr/tile_quality.h"

namespace wheatstone::apps {

struct TileAllocation {
  AllocationProblem problem;
  Allocation allocation;
  ShadingRateMap map;
};

struct TileOptions {
  std::string motion, materials, luminance, polynomials;
  double luminance_cd_m2 = 100;
  FrameGeometry geometry;
  double budget = 0;  // fraction of full rate
  std::string solver = "fast";

  /// Adds everything but --solver.
  void add_to(CLI::App& command);

  /// Errors: ArgumentError for an option that is missing; those of read_tile_buffers().
  TileBuffers read_buffers() const;
  /// Errors: those of PolynomialTable::read(), TileQualityModel, budget_px() and allocate().
  TileAllocation solve(const TileBuffers&) const;
};

/// Quality, cost and bound as one line for people.
std::string describe(const AllocationProblem&, const Allocation&);

}  // namespace wheatstone::apps
