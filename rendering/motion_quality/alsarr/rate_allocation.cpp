#include "rendering/motion_quality/alsarr/rate_allocation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/error.h"
#include "rendering/motion_quality/alsarr/multiple_choice_knapsack.h"

namespace wheatstone {
namespace {

constexpr int kMaxCost = 1'000'000;
constexpr double kMaxQuality = 1e100;  // sums and slopes stay finite
constexpr std::size_t kExactTableBytes = std::size_t{1} << 30;
// Less than a millisecond; frames of full HD need some thousands.
constexpr std::int64_t kFastUpdates = 250'000;

void require_solvable(const AllocationProblem& p) {
  if (p.quality.empty() || p.quality.size() % kShadingRateCount != 0)
    throw ArgumentError(
        fmt::format("{} qualities for {} rates per tile", p.quality.size(), kShadingRateCount),
        "give seven qualities for each of one or more tiles");
  for (std::size_t i = 0; i < p.quality.size(); ++i)
    if (!(std::abs(p.quality[i]) <= kMaxQuality))
      throw ArgumentError(
          fmt::format("the quality of tile {} at rate {} is {}", i / kShadingRateCount,
                      kShadingRates[i % kShadingRateCount].name, p.quality[i]),
          fmt::format("give finite qualities, at most {:g} in size", kMaxQuality));
  for (int k = 0; k < kShadingRateCount; ++k)
    if (p.cost[k] < 1 || p.cost[k] > kMaxCost || p.cost[k] < p.cost[0])
      throw ArgumentError(fmt::format("rate {} costs {}, rate {} costs {}", kShadingRates[0].name,
                                      p.cost[0], kShadingRates[k].name, p.cost[k]),
                          "give costs of 1 to 1000000, none below the first");
  const std::int64_t least = p.cost[0] * static_cast<std::int64_t>(p.tiles());
  if (p.budget < least)
    throw ArgumentError(fmt::format("a budget of {} is too small for {} tiles of at least {}",
                                    p.budget, p.tiles(), p.cost[0]),
                        fmt::format("the least that would do is {}", least));
}

detail::Knapsack as_knapsack(const AllocationProblem& p) {
  detail::Knapsack out;
  int divisor = 0;
  for (const int cost : p.cost) divisor = std::gcd(divisor, cost - p.cost[0]);
  divisor = std::max(divisor, 1);
  for (int k = 0; k < kShadingRateCount; ++k) out.cost[k] = (p.cost[k] - p.cost[0]) / divisor;
  out.capacity = (p.budget - p.cost[0] * static_cast<std::int64_t>(p.tiles())) / divisor;
  out.quality = p.quality;
  return out;
}

/// selection: 0..6 per tile.
Allocation summary(const AllocationProblem& p, const std::vector<std::uint8_t>& selection) {
  Allocation out;
  out.choice.resize(selection.size());
  for (std::size_t tile = 0; tile < selection.size(); ++tile) {
    out.choice[tile] = static_cast<std::uint8_t>(selection[tile] + 1);
    out.total_quality += p.quality[tile * kShadingRateCount + selection[tile]];
    out.total_cost += p.cost[selection[tile]];
  }
  WHEATSTONE_CHECK(out.total_cost, <=, p.budget);
  return out;
}

/// The released program, its rules in the reference's words: the walk leaves out the list's last
/// entry, and ends at the first step that does not fit.
std::vector<std::uint8_t> greedy_selection(const AllocationProblem& p) {
  struct Entry {
    double ratio;
    std::uint32_t tile;
    std::uint8_t rate;
  };
  std::vector<Entry> entries;
  entries.reserve(p.quality.size());
  for (std::size_t tile = 0; tile < p.tiles(); ++tile)
    for (int k = 1; k < kShadingRateCount; ++k)
      entries.push_back({p.quality[tile * kShadingRateCount + k] / p.cost[k],
                         static_cast<std::uint32_t>(tile), static_cast<std::uint8_t>(k)});
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return a.ratio > b.ratio; });
  entries.pop_back();

  std::vector<std::uint8_t> selection(p.tiles(), 0);
  std::int64_t left = p.budget - p.cost[0] * static_cast<std::int64_t>(p.tiles());
  for (const Entry& e : entries) {
    const double* quality = p.quality.data() + std::size_t{e.tile} * kShadingRateCount;
    const int current = selection[e.tile];
    if (!(quality[e.rate] > quality[current])) continue;
    left -= p.cost[e.rate] - p.cost[current];
    if (left < 0) break;
    selection[e.tile] = e.rate;
  }
  return selection;
}

/// The relaxed optimum's value: no selection within the budget is better.
double relaxed_value(const detail::Knapsack& k, const detail::Relaxation& r) {
  double sum = r.multiplier * static_cast<double>(r.slack);
  for (std::size_t tile = 0; tile < k.tiles(); ++tile)
    sum += k.quality[tile * kShadingRateCount + r.selection[tile]];
  return sum;
}

}  // namespace

AllocationSolver allocation_solver_from_string(const std::string& name) {
  if (name == "greedy") return AllocationSolver::kGreedy;
  if (name == "exact") return AllocationSolver::kExact;
  if (name == "fast") return AllocationSolver::kFast;
  throw ArgumentError("there is no solver '" + name + "'", "use greedy, exact or fast");
}

Allocation allocate(const AllocationProblem& problem, AllocationSolver solver) {
  require_solvable(problem);
  const detail::Knapsack knapsack = as_knapsack(problem);
  const detail::Relaxation relaxed = detail::relax(knapsack);
  const auto bounded_greedy = [&] {
    Allocation greedy = summary(problem, greedy_selection(problem));
    greedy.gap_bound = std::max(relaxed_value(knapsack, relaxed) - greedy.total_quality, 0.0);
    return greedy;
  };
  if (solver == AllocationSolver::kGreedy) return bounded_greedy();

  const bool exact = solver == AllocationSolver::kExact;
  const detail::SearchResult found = detail::search_core(
      knapsack, relaxed,
      {kExactTableBytes, exact ? std::numeric_limits<std::int64_t>::max() : kFastUpdates});
  if (exact && !found.optimal)
    throw ArgumentError("the exact optimum of this problem needs a table of more than 1 GiB",
                        "use the fast solver, whose answer comes with a bound");
  Allocation out = summary(problem, found.selection);
  if (found.optimal) return out;
  out.gap_bound = found.loss;
  // Unproved, so greedy may be the better one.
  if (Allocation greedy = bounded_greedy(); greedy.total_quality > out.total_quality) return greedy;
  return out;
}

std::int64_t budget_px(double fraction, std::size_t tiles) {
  constexpr int kFull = kShadingRates.back().cost_px(), kLeast = kShadingRates.front().cost_px();
  if (!(fraction * kFull >= kLeast && fraction <= 1))
    throw ArgumentError(fmt::format("a budget of {} of full rate is not possible", fraction),
                        "give 0.0625 (4x4 everywhere, the least) to 1");
  return static_cast<std::int64_t>(fraction * kFull * static_cast<double>(tiles));
}

}  // namespace wheatstone
