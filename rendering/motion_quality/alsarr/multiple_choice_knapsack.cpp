#include "rendering/motion_quality/alsarr/multiple_choice_knapsack.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

namespace wheatstone::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Rates = std::array<std::uint8_t, kShadingRateCount>;

/// A step up a tile's concave hull of quality over cost.
struct Step {
  double slope = 0;  // quality per unit of cost, > 0
  std::int32_t cost = 0;
  std::uint32_t tile = 0;
  std::uint8_t rate = 0;  // reached by the step
};

/// Appends a tile's hull steps, slopes falling; returns the cheapest rate, where the hull begins.
std::uint8_t append_hull(const Knapsack& problem, const Rates& by_cost, std::uint32_t tile,
                         std::vector<Step>& steps) {
  const double* quality = problem.quality.data() + std::size_t{tile} * kShadingRateCount;
  const std::size_t first_step = steps.size();
  std::uint8_t start = by_cost[0];
  const auto top = [&] { return steps.size() > first_step ? steps.back().rate : start; };
  for (int i = 1; i < kShadingRateCount; ++i) {
    const std::uint8_t rate = by_cost[i];
    if (quality[rate] <= quality[top()]) continue;  // costs no less and is no better
    const auto cost = [&] { return problem.cost[rate] - problem.cost[top()]; };
    const auto slope = [&] {
      return cost() > 0 ? (quality[rate] - quality[top()]) / cost() : kInfinity;
    };
    while (steps.size() > first_step && slope() >= steps.back().slope)
      steps.pop_back();  // that rate lies below the hull
    if (cost() == 0)
      start = rate;
    else
      steps.push_back({slope(), cost(), tile, rate});
  }
  return start;
}

/// Slopes in falling order of these bins, within which they differ by less than 1/64.
constexpr std::size_t kSlopeBins = std::size_t{1} << 14;
std::size_t slope_bin(double slope) {
  return std::bit_cast<std::uint32_t>(static_cast<float>(slope)) >> 17;
}

}  // namespace

Relaxation relax(const Knapsack& problem) {
  Rates by_cost{};
  std::iota(by_cost.begin(), by_cost.end(), std::uint8_t{0});
  std::stable_sort(by_cost.begin(), by_cost.end(),
                   [&](int a, int b) { return problem.cost[a] < problem.cost[b]; });

  Relaxation out;
  out.slack = problem.capacity;
  out.selection.resize(problem.tiles());
  std::vector<Step> steps;
  steps.reserve(problem.tiles() * (kShadingRateCount - 1));
  for (std::size_t tile = 0; tile < problem.tiles(); ++tile)
    out.selection[tile] = append_hull(problem, by_cost, static_cast<std::uint32_t>(tile), steps);

  // The steepest steps are taken; the first that does not fit gives the multiplier. A histogram
  // finds its bin, so that only the steps in that bin have to be sorted.
  std::vector<std::int64_t> cost_in_bin(kSlopeBins, 0);
  for (const Step& step : steps) cost_in_bin[slope_bin(step.slope)] += step.cost;
  std::size_t bin = kSlopeBins;
  while (bin > 0 && cost_in_bin[bin - 1] <= out.slack) out.slack -= cost_in_bin[--bin];
  std::vector<Step> marginal;
  for (const Step& step : steps) {
    const std::size_t own = slope_bin(step.slope);
    if (own >= bin) out.selection[step.tile] = step.rate;
    if (own + 1 == bin) marginal.push_back(step);
  }
  std::sort(marginal.begin(), marginal.end(), [](const Step& a, const Step& b) {
    return a.slope != b.slope ? a.slope > b.slope : a.tile < b.tile;
  });
  for (const Step& step : marginal) {
    if (step.cost > out.slack) {
      out.multiplier = step.slope;
      break;
    }
    out.slack -= step.cost;
    out.selection[step.tile] = step.rate;
  }
  return out;
}

namespace {

/// A tile that may leave its relaxed rate, by the least it loses then.
struct CoreTile {
  double least_loss = 0;
  std::uint32_t tile = 0;
};

class CoreSearch {
 public:
  CoreSearch(const Knapsack& problem, const Relaxation& relaxed)
      : problem_(problem), relaxed_(relaxed) {
    result_.selection = relaxed.selection;
    result_.loss = loss_with_slack(0, 0);
  }

  SearchResult run(const SearchLimits& limits) {
    const std::vector<double> least_loss = take_best_single_move();
    std::vector<CoreTile> core;
    for (std::size_t tile = 0; tile < least_loss.size(); ++tile)
      if (least_loss[tile] < result_.loss)
        core.push_back({least_loss[tile], static_cast<std::uint32_t>(tile)});
    for (const CoreTile& c : core) {
      up_rest_ += max_cost_ - base_cost(c.tile);
      down_rest_ += base_cost(c.tile);
    }
    // A heap, because the first few tiles usually prove that no other is needed.
    std::make_heap(core.begin(), core.end(), later);
    result_.optimal = true;
    for (; !core.empty() && core.front().least_loss < result_.loss; core.pop_back()) {
      std::pop_heap(core.begin(), core.end(), later);
      if (!expand(core.back().tile, limits)) {
        result_.optimal = false;
        break;
      }
    }
    trace_back();
    return std::move(result_);
  }

 private:
  static bool later(const CoreTile& a, const CoreTile& b) {
    return a.least_loss != b.least_loss ? a.least_loss > b.least_loss : a.tile > b.tile;
  }

  /// What one layer of the dynamic program chose for its tile, by offset.
  struct Layer {
    std::uint32_t tile;
    std::int64_t low;         // offset of the first state
    std::size_t picks_begin;  // in picks_
  };

  int base_cost(std::size_t tile) const { return problem_.cost[relaxed_.selection[tile]]; }

  double loss_with_slack(double loss, std::int64_t offset) const {
    return loss + relaxed_.multiplier * static_cast<double>(relaxed_.slack - offset);
  }

  /// What a tile loses at each rate.
  std::array<double, kShadingRateCount> losses(std::size_t tile) const {
    const double* quality = problem_.quality.data() + tile * kShadingRateCount;
    std::array<double, kShadingRateCount> out;
    for (int k = 0; k < kShadingRateCount; ++k)
      out[k] = quality[k] - relaxed_.multiplier * problem_.cost[k];
    const double best = out[relaxed_.selection[tile]];
    for (double& v : out) v = std::max(best - v, 0.0);  // < 0 by rounding only
    return out;
  }

  /// Changes one tile where that is best; returns the least that each tile loses off its rate.
  std::vector<double> take_best_single_move() {
    std::vector<double> least(problem_.tiles());
    std::size_t best_tile = 0;
    int best_rate = relaxed_.selection.empty() ? 0 : relaxed_.selection[0];
    for (std::size_t tile = 0; tile < least.size(); ++tile) {
      const auto loss = losses(tile);
      const int base = relaxed_.selection[tile];
      double smallest = kInfinity;
      for (int k = 0; k < kShadingRateCount; ++k)
        if (k != base) smallest = std::min(smallest, loss[k]);
      least[tile] = smallest;
      if (smallest >= result_.loss) continue;
      for (int k = 0; k < kShadingRateCount; ++k) {
        const std::int64_t offset = problem_.cost[k] - problem_.cost[base];
        if (offset > relaxed_.slack || !(loss_with_slack(loss[k], offset) < result_.loss)) continue;
        result_.loss = loss_with_slack(loss[k], offset);
        best_tile = tile;
        best_rate = k;
      }
    }
    if (!least.empty()) result_.selection[best_tile] = static_cast<std::uint8_t>(best_rate);
    return least;
  }

  /// Adds one tile to the dynamic program. false: a limit is met, nothing has changed.
  bool expand(std::uint32_t tile, const SearchLimits& limits) {
    const auto loss = losses(tile);
    const int base = relaxed_.selection[tile];
    up_rest_ -= max_cost_ - base_cost(tile);
    down_rest_ -= base_cost(tile);

    std::vector<int> rates;
    int down = 0, up = 0;
    for (int k = 0; k < kShadingRateCount; ++k) {
      if (k != base && !(loss[k] < result_.loss)) continue;
      rates.push_back(k);
      down = std::min(down, problem_.cost[k] - problem_.cost[base]);
      up = std::max(up, problem_.cost[k] - problem_.cost[base]);
    }
    // States from which the remaining tiles can still come to a better selection.
    const double affordable_slack = result_.loss / relaxed_.multiplier;
    std::int64_t low = low_ + down, high = low_ + std::ssize(states_) - 1 + up;
    if (affordable_slack < static_cast<double>(relaxed_.slack - up_rest_ - low))
      low = relaxed_.slack - up_rest_ - static_cast<std::int64_t>(affordable_slack);
    high = std::min(high, relaxed_.slack + down_rest_);
    const auto width = static_cast<std::size_t>(std::max<std::int64_t>(high - low + 1, 0));

    updates_ += static_cast<std::int64_t>(width * rates.size());
    if (updates_ > limits.max_updates || picks_.size() + (width + 1) / 2 > limits.max_table_bytes)
      return false;

    std::vector<double> next(width, kInfinity);
    std::vector<std::uint8_t> pick(width + 1, static_cast<std::uint8_t>(base));
    for (const int k : rates) {
      const std::int64_t shift = low_ + problem_.cost[k] - problem_.cost[base] - low;
      const std::int64_t begin = std::max<std::int64_t>(0, -shift);
      const std::int64_t end = std::min(std::ssize(states_), std::ssize(next) - shift);
      for (std::int64_t i = begin; i < end; ++i) {
        const double v = states_[i] + loss[k];
        if (v < next[i + shift]) {
          next[i + shift] = v;
          pick[i + shift] = static_cast<std::uint8_t>(k);
        }
      }
    }
    layers_.push_back({tile, low, picks_.size()});
    for (std::size_t i = 0; i < width; i += 2)
      picks_.push_back(static_cast<std::uint8_t>(pick[i] | pick[i + 1] << 4));
    keep_promising(next, low);
    return true;
  }

  /// Takes over the new states, notes the best selection among them and drops hopeless ends.
  void keep_promising(std::vector<double>& next, std::int64_t low) {
    for (std::int64_t i = 0; i < std::ssize(next) && low + i <= relaxed_.slack; ++i)
      if (const double total = loss_with_slack(next[i], low + i); total < result_.loss) {
        result_.loss = total;
        best_layers_ = layers_.size();
        best_offset_ = low + i;
      }
    const auto promising = [&](double v) { return v < result_.loss; };
    const auto first = std::find_if(next.begin(), next.end(), promising);
    const auto last = std::find_if(next.rbegin(), std::make_reverse_iterator(first), promising);
    low_ = low + (first - next.begin());
    next.erase(last.base(), next.end());
    next.erase(next.begin(), first);
    states_.swap(next);
  }

  void trace_back() {
    if (best_layers_ == 0) return;  // the single move, or none
    result_.selection = relaxed_.selection;
    for (std::size_t i = best_layers_; i-- > 0;) {
      const Layer& layer = layers_[i];
      const auto at = static_cast<std::size_t>(best_offset_ - layer.low);
      const int rate = picks_[layer.picks_begin + at / 2] >> (at % 2 ? 4 : 0) & 15;
      best_offset_ -= problem_.cost[rate] - base_cost(layer.tile);
      result_.selection[layer.tile] = static_cast<std::uint8_t>(rate);
    }
  }

  const Knapsack& problem_;
  const Relaxation& relaxed_;
  const int max_cost_ = *std::max_element(problem_.cost.begin(), problem_.cost.end());
  SearchResult result_;

  // States: the least loss for each cost offset from the relaxed selection, low_ and up.
  std::vector<double> states_ = {0};
  std::int64_t low_ = 0;
  std::int64_t up_rest_ = 0, down_rest_ = 0;  // the most that tiles not yet expanded can change
  std::int64_t updates_ = 0;
  std::vector<Layer> layers_;
  std::vector<std::uint8_t> picks_;  // two rates a byte
  std::size_t best_layers_ = 0;
  std::int64_t best_offset_ = 0;
};

}  // namespace

SearchResult search_core(const Knapsack& problem, const Relaxation& relaxed,
                         const SearchLimits& limits) {
  return CoreSearch(problem, relaxed).run(limits);
}

}  // namespace wheatstone::detail
