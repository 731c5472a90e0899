#include "rendering/motion_quality/alsarr/refresh_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/csv.h"
#include "core/error.h"

namespace wheatstone {
namespace {

constexpr double kImpossible = -100;      // quality of a reduction above 1
constexpr double kReductionSlack = 1e-3;  // what rounding may add to 1
constexpr double kNoDifference = 0.01;

/// From the highest rate downwards.
std::vector<double> refresh_rates(const RefreshSearch& s) {
  if (!(s.min_refresh_hz > 0 && s.max_refresh_hz >= s.min_refresh_hz && s.step_hz > 0) ||
      !std::isfinite(s.max_refresh_hz) || (s.max_refresh_hz - s.min_refresh_hz) / s.step_hz > 1e4)
    throw ArgumentError(fmt::format("there is no way from {} to {} Hz in steps of {}",
                                    s.min_refresh_hz, s.max_refresh_hz, s.step_hz),
                        "give a positive range and step");
  std::vector<double> out;
  for (int i = 0;; ++i) {
    const double refresh_hz = s.max_refresh_hz - i * s.step_hz;
    if (refresh_hz < s.min_refresh_hz - 1e-9) return out;
    out.push_back(refresh_hz);
  }
}

/// The best of the candidates for one budget and speed, as the header describes.
const RefreshCandidate& best_of(std::span<const RefreshCandidate> candidates) {
  double worst = candidates[0].quality;
  for (const RefreshCandidate& c : candidates) worst = std::min(worst, c.quality);
  const auto above_worst = [&](const RefreshCandidate& c) {
    return c.quality - worst < kNoDifference ? 0 : c.quality - worst;
  };
  const RefreshCandidate* best = candidates.data();
  for (const RefreshCandidate& c : candidates)
    if (above_worst(c) > above_worst(*best)) best = &c;
  return *best;
}

}  // namespace

RefreshTable::RefreshTable(const Camojab& camojab, std::span<const double> budget_fractions,
                           std::span<const double> speeds_deg_per_s, const RefreshSearch& search) {
  const std::vector<double> rates_hz = refresh_rates(search);
  if (budget_fractions.empty() || speeds_deg_per_s.empty())
    throw ArgumentError("a refresh table without budgets or speeds", "give at least one of each");
  std::vector<CamojabConditions> conditions;  // of the candidates that are possible
  for (const double fraction : budget_fractions) {
    if (!(fraction > 0 && fraction <= 1))
      throw ArgumentError(fmt::format("a budget of {} of full rate is not possible", fraction),
                          "give more than 0, at most 1");
    for (const double speed : speeds_deg_per_s)
      for (const double refresh_hz : rates_hz) {
        const double reduction = std::sqrt(fraction * search.max_refresh_hz / refresh_hz);
        candidates_.push_back({fraction, speed, refresh_hz, reduction, kImpossible});
        if (reduction > 1 + kReductionSlack) continue;
        const double rate = std::min(reduction, 1.0);
        conditions.push_back({search.ppd, refresh_hz, speed, search.persistence,
                              search.luminance_cd_m2, search.mip_level, rate, rate});
      }
  }
  const std::vector<CamojabQuality> qualities = camojab.evaluate(conditions);
  std::size_t next = 0;
  for (RefreshCandidate& c : candidates_)
    if (c.resolution_reduction <= 1 + kReductionSlack) c.quality = qualities[next++].quality;

  for (std::size_t i = 0; i < candidates_.size(); i += rates_hz.size()) {
    const RefreshCandidate& best = best_of(std::span(candidates_).subspan(i, rates_hz.size()));
    entries_.push_back({best.budget_fraction, best.speed_deg_per_s, best.refresh_hz});
  }
}

const RefreshEntry& RefreshTable::nearest(double budget_fraction, double speed_deg_per_s) const {
  if (!(speed_deg_per_s >= 0) || std::isnan(budget_fraction))
    throw ArgumentError(
        fmt::format("a speed of {} deg/s, a budget of {}", speed_deg_per_s, budget_fraction),
        "give a speed of at least 0 and a budget");
  const auto distance = [&](const RefreshEntry& e) {
    return std::pair(std::abs(e.budget_fraction - budget_fraction),
                     std::abs(e.speed_deg_per_s - speed_deg_per_s));
  };
  return *std::min_element(
      entries_.begin(), entries_.end(),
      [&](const RefreshEntry& a, const RefreshEntry& b) { return distance(a) < distance(b); });
}

void RefreshTable::write(const std::filesystem::path& path) const {
  CsvTable table({"bandwidth_fraction", "velocity_deg_s", "best_refresh_hz"});
  for (const RefreshEntry& e : entries_)
    table.add_row({fmt::format("{}", e.budget_fraction), fmt::format("{}", e.speed_deg_per_s),
                   fmt::format("{}", e.best_refresh_hz)});
  table.write(path);
}

void RefreshTable::write_candidates(const std::filesystem::path& path) const {
  CsvTable table(
      {"bandwidth_fraction", "velocity_deg_s", "refresh_hz", "resolution_reduction", "Q"});
  for (const RefreshCandidate& c : candidates_)
    table.add_row({fmt::format("{}", c.budget_fraction), fmt::format("{}", c.speed_deg_per_s),
                   fmt::format("{}", c.refresh_hz), fmt::format("{}", c.resolution_reduction),
                   fmt::format("{}", c.quality)});
  table.write(path);
}

double frame_speed_deg_per_s(const TileBuffers& buffers) {
  require_valid(buffers);
  double sum = 0;
  for (int y = 0; y < buffers.tiles_y(); ++y)
    for (int x = 0; x < buffers.tiles_x(); ++x)
      sum += std::hypot(buffers.speed_x_deg_per_s(y, x), buffers.speed_y_deg_per_s(y, x));
  return sum / static_cast<double>(buffers.material.total());
}

}  // namespace wheatstone
