#pragma once
// Allocation problems and their answers as JSON (docs/shading_rates.md).

#include <filesystem>
#include <string>

#include "rendering/motion_quality/alsarr/rate_allocation.h"

namespace wheatstone::apps {

/// An instance: an object with "budget", "bandwidth" (the cost of each rate, in the budget's unit)
/// and "quality" (seven numbers per tile), or instead of "quality" the recipe "lcg_seed" and "mode"
/// (0, 1, 2) with "tiles_x" and "tiles_y". A file that holds a list "instances" needs the `name` of
/// one. Errors: FileError: not such a file (key and tile named); values are judged by allocate().
AllocationProblem read_allocation_instance(const std::filesystem::path&,
                                           const std::string& name = "");

/// solver, total_quality, total_cost, budget, gap_bound, choice. Atomic.
void write_allocation(const std::filesystem::path&, const std::string& solver,
                      const AllocationProblem&, const Allocation&);

}  // namespace wheatstone::apps
