#pragma once
// Random allocation problems, and the plain dynamic program that answers are compared with.

#include <algorithm>
#include <limits>
#include <vector>

#include "core/random.h"
#include "rendering/motion_quality/alsarr/rate_allocation.h"

namespace wheatstone::testing {

/// The reference's three kinds of random qualities (vectors' README, "Knapsack instances"): 0 as
/// drawn, 1 in quarters (many ties), 2 with negative ones; costs in the released unit. Kind 3 is
/// our own: concave qualities with a common slope, the hardest for a search near the relaxation.
inline AllocationProblem random_problem(int kind, int tiles, std::uint64_t seed) {
  RandomStream random(seed, static_cast<std::uint64_t>(kind));
  AllocationProblem p;
  p.cost = {1, 2, 2, 4, 8, 8, 16};
  for (int tile = 0; tile < tiles; ++tile) {
    const auto draw = [&] {
      const double u = random.uniform();
      return kind == 1 ? std::floor(4 * u) / 4 : u;
    };
    const double o = kind == 2 ? 0.75 : 0;
    const double hx = 3 * draw() - o, fx = hx + 4 * draw() - o;
    const double hy = 3 * draw() - o, fy = hy + 4 * draw() - o;
    if (kind == 3)
      for (const int cost : p.cost) p.quality.push_back(cost + 0.5 * (draw() > 0.5));
    else
      for (const double q :
           {0.0, hx / 2, hy / 2, (hx + hy) / 2, (fx + hy) / 2, (hx + fy) / 2, (fx + fy) / 2})
        p.quality.push_back(q + 0.1);
  }
  return p;
}

/// The optimum by dynamic programming over the whole budget; unreachable states are -infinity.
inline double optimum_by_dynamic_programming(const AllocationProblem& p) {
  const auto budget = static_cast<std::size_t>(p.budget);
  constexpr double kUnreachable = -std::numeric_limits<double>::infinity();
  std::vector<double> best(budget + 1, kUnreachable), next(budget + 1);
  best[0] = 0;
  for (std::size_t tile = 0; tile < p.tiles(); ++tile) {
    std::fill(next.begin(), next.end(), kUnreachable);
    for (int k = 0; k < kShadingRateCount; ++k)
      for (std::size_t used = static_cast<std::size_t>(p.cost[k]); used <= budget; ++used)
        next[used] = std::max(next[used], best[used - static_cast<std::size_t>(p.cost[k])] +
                                              p.quality[tile * kShadingRateCount + k]);
    best.swap(next);
  }
  return *std::max_element(best.begin(), best.end());
}

}  // namespace wheatstone::testing
