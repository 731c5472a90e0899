#include "apps/commands/tile_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "core/error.h"

namespace wheatstone::apps {

void TileOptions::add_to(CLI::App& command) {
  command.add_option("--motion", motion,
                     "EXR of tiles: R, G = motion, per cent of the frame per refresh");
  command.add_option("--materials", materials, "EXR of tiles: R = material from 0, G = mip level");
  command.add_option("--polynomials", polynomials, "CSV with the quality of each material");
  command.add_option("--budget", budget, "fraction of full rate, 0.0625 to 1");
  command.add_option("--luminance", luminance, "EXR of tiles: Y = cd/m² of the frame before");
  command.add_option("--luminance-cd-m2", luminance_cd_m2, "of all tiles without such a file")
      ->capture_default_str();
  command.add_option("--width-px", geometry.width_px, "of the frame")->capture_default_str();
  command.add_option("--height-px", geometry.height_px, "of the frame")->capture_default_str();
  command.add_option("--refresh-hz", geometry.refresh_hz, "of the display")->capture_default_str();
  command.add_option("--ppd", geometry.ppd, "pixels per degree")->capture_default_str();
}

TileBuffers TileOptions::read_buffers() const {
  for (const auto& [value, option] : {std::pair(&motion, "--motion"),
                                      {&materials, "--materials"},
                                      {&polynomials, "--polynomials"}})
    if (value->empty())
      throw ArgumentError(fmt::format("there is no {}", option),
                          "tile buffers need --motion, --materials, --polynomials and --budget");
  TileBufferFiles files{motion, materials, {}, luminance_cd_m2};
  if (!luminance.empty()) files.luminance = luminance;
  return read_tile_buffers(files, geometry);
}

TileAllocation TileOptions::solve(const TileBuffers& buffers) const {
  const AllocationSolver chosen = allocation_solver_from_string(solver);
  TileAllocation out;
  out.problem.budget = budget_px(budget, buffers.material.total());
  out.problem.quality =
      TileQualityModel(PolynomialTable::read(polynomials), geometry.refresh_hz).evaluate(buffers);
  out.allocation = allocate(out.problem, chosen);
  out.map = shading_rate_map(out.allocation.choice, buffers.tiles_x(), buffers.tiles_y());
  return out;
}

std::string describe(const AllocationProblem& problem, const Allocation& allocation) {
  return fmt::format("quality {:.6f}, cost {} of {}, {}", allocation.total_quality,
                     allocation.total_cost, problem.budget,
                     allocation.gap_bound == 0
                         ? "an optimum"
                         : fmt::format("at most {:.2g} below the optimum", allocation.gap_bound));
}

}  // namespace wheatstone::apps
