#pragma once
// Which shading rate each tile gets, so that a frame has the best quality within a budget of
// shades: a multiple-choice knapsack problem. Source: thesis (UCAM-CL-TR-977), section 6.3 and
// algorithm 1; A. Jindal et al., ACM TOG 40(6), 2021; reference motion_quality.md, section 4.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "rendering/motion_quality/alsarr/shading_rate.h"

namespace wheatstone {

/// Maximise the sum of quality subject to sum of cost <= budget, one rate per tile.
struct AllocationProblem {
  /// Of each rate, in the budget's unit. Default: shades per tile (thesis), 16..256; the released
  /// programs count sixteenths of that. Any positive integers will do, as long as rate 1 (4x4) is
  /// cheapest: it is what every tile starts from.
  std::array<int, kShadingRateCount> cost = default_costs();
  std::int64_t budget = 0;
  std::vector<double> quality;  // [tile][rate], any finite numbers

  std::size_t tiles() const { return quality.size() / kShadingRateCount; }
  static constexpr std::array<int, kShadingRateCount> default_costs() {
    std::array<int, kShadingRateCount> out{};
    for (int i = 0; i < kShadingRateCount; ++i) out[i] = kShadingRates[i].cost_px();
    return out;
  }
};

struct Allocation {
  std::vector<std::uint8_t> choice;  // rate index 1..7 of each tile
  double total_quality = 0;
  std::int64_t total_cost = 0;  // never above the budget
  /// The optimum is at most total_quality + gap_bound: 0 (up to rounding, about 1e-15 of the
  /// qualities) where optimality is proved, else the distance to the linear relaxation.
  double gap_bound = 0;
};

enum class AllocationSolver {
  kGreedy,  // the released program's choices, by quality per cost
  kExact,   // an optimum, however long it takes
  kFast     // for every frame: bounded work; no worse than kGreedy, nearly always an optimum
};
AllocationSolver allocation_solver_from_string(const std::string&);  // "greedy", "exact", "fast"

/// Deterministic, single-threaded.
/// Errors: ArgumentError for no tiles, a quality that is not finite or beyond 1e100 (tile and rate
/// named), costs out of 1..1000000 or with rate 1 not the cheapest, a budget below the minimum
/// (which is named); kExact also when its table would exceed 1 GiB, which cannot happen up to
/// 8,160 tiles with the default costs.
Allocation allocate(const AllocationProblem&, AllocationSolver);

/// The budget in shades that is `fraction` of full rate on all tiles, rounded down.
/// Errors: ArgumentError unless 1/16 <= fraction <= 1, 1/16 being 4x4 everywhere.
std::int64_t budget_px(double fraction, std::size_t tiles);

}  // namespace wheatstone
