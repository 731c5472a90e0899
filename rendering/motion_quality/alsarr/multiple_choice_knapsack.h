#pragma once
// Inside of rate_allocation.cpp: the linear relaxation of the multiple-choice knapsack, and the
// search for the integer optimum near it.
//
// With the relaxation's multiplier m, a selection's distance from the relaxed optimum is
//     loss = sum of (best - own) of quality - m cost, over the tiles, + m (capacity - cost used),
// whose terms are all >= 0. So a tile whose second-best rate loses more than the best selection
// found so far keeps its best rate in every optimum. What remains, the core, is small and is solved
// by dynamic programming over the cost relative to the relaxed selection.
// Sources: E. Balas and E. Zemel, Operations Research 28(5), 1980 (core); D. Pisinger, EJOR 83(2),
// 1995 (expanding core for the multiple-choice problem).

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "rendering/motion_quality/alsarr/shading_rate.h"

namespace wheatstone::detail {

/// Costs relative to the cheapest rate and without a common factor: the cheapest costs 0.
struct Knapsack {
  std::array<int, kShadingRateCount> cost{};
  std::int64_t capacity = 0;
  std::span<const double> quality;  // [tile][rate]

  std::size_t tiles() const { return quality.size() / kShadingRateCount; }
};

struct Relaxation {
  double multiplier = 0;                // quality per unit of cost, >= 0
  std::vector<std::uint8_t> selection;  // 0..6 per tile; maximal in quality - multiplier cost
  std::int64_t slack = 0;               // capacity left by the selection, >= 0
};
/// The relaxed optimum, rounded down to whole rates.
Relaxation relax(const Knapsack&);

struct SearchLimits {
  std::size_t max_table_bytes = 0;  // for tracing the optimum back
  std::int64_t max_updates = 0;     // of dynamic-programming states
};
struct SearchResult {
  std::vector<std::uint8_t> selection;  // 0..6 per tile
  double loss = 0;                      // distance from the relaxed optimum
  bool optimal = false;                 // false: a limit was met
};
SearchResult search_core(const Knapsack&, const Relaxation&, const SearchLimits&);

}  // namespace wheatstone::detail
