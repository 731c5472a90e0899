#pragma once
// Which refresh rate is best for a speed and a budget of pixels per second: more frames of lower
// resolution, or fewer of higher. Source: thesis (UCAM-CL-TR-977), section 6.3.2; reference
// motion_quality.md, section 4, "Refresh-rate table".

#include <filesystem>
#include <span>
#include <vector>

#include "rendering/motion_quality/alsarr/tile_buffers.h"
#include "rendering/motion_quality/camojab.h"

namespace wheatstone {

struct RefreshSearch {
  double min_refresh_hz = 30, max_refresh_hz = 120, step_hz = 5;
  double ppd = 45, luminance_cd_m2 = 100, persistence = 1, mip_level = 0;
};

/// One refresh rate at one budget and speed.
struct RefreshCandidate {
  double budget_fraction = 0;  // of full resolution at max_refresh_hz
  double speed_deg_per_s = 0;
  double refresh_hz = 0;
  double resolution_reduction = 0;  // per axis: sqrt(budget / (refresh rate x pixels))
  double quality = 0;               // CaMoJAB's Q at that reduction, -100 where it would exceed 1
};
struct RefreshEntry {
  double budget_fraction = 0, speed_deg_per_s = 0, best_refresh_hz = 0;
};

class RefreshTable {
 public:
  /// Evaluates every combination for a texture, in parallel; the same for any number of threads.
  /// Qualities are compared above the worst candidate's, and differences of less than 0.01 from it
  /// count as none; ties go to the higher refresh rate.
  /// Errors: ArgumentError for no fractions or speeds, a fraction outside (0, 1], a range of
  /// refresh rates that is not one, or conditions that CaMoJAB refuses (a negative speed).
  RefreshTable(const Camojab&, std::span<const double> budget_fractions,
               std::span<const double> speeds_deg_per_s, const RefreshSearch& = {});

  /// By fraction, speed and falling refresh rate.
  const std::vector<RefreshCandidate>& candidates() const { return candidates_; }
  const std::vector<RefreshEntry>& entries() const { return entries_; }  // by fraction and speed

  /// The entry of the nearest fraction and, for it, the nearest speed.
  /// Errors: ArgumentError for a negative speed or NaN.
  const RefreshEntry& nearest(double budget_fraction, double speed_deg_per_s) const;

  /// Columns bandwidth_fraction, velocity_deg_s, best_refresh_hz; atomic.
  void write(const std::filesystem::path&) const;
  /// Columns bandwidth_fraction, velocity_deg_s, refresh_hz, resolution_reduction, Q; atomic.
  void write_candidates(const std::filesystem::path&) const;

 private:
  std::vector<RefreshCandidate> candidates_;
  std::vector<RefreshEntry> entries_;
};

/// What the table is asked with: the mean over the tiles of the speed's magnitude.
double frame_speed_deg_per_s(const TileBuffers&);

}  // namespace wheatstone
