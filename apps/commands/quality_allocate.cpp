#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/allocation_instance.h"
#include "apps/commands/quality.h"
#include "apps/commands/tile_options.h"
#include "apps/shading_rate_pictures.h"
#include "core/error.h"
#include "core/png.h"

namespace wheatstone::apps {
namespace {

struct Options {
  std::string input, instance, output, map, picture;
  TileOptions tiles;
};

void allocate_instance(const Options& o) {
  if (o.output.empty() || !o.map.empty() || !o.picture.empty())
    throw ArgumentError("an instance has no places for a map or a picture",
                        "give --output alone with --input");
  const AllocationProblem problem = read_allocation_instance(o.input, o.instance);
  const Allocation allocation = allocate(problem, allocation_solver_from_string(o.tiles.solver));
  write_allocation(o.output, o.tiles.solver, problem, allocation);
  fmt::print("{}\n", describe(problem, allocation));
}

void allocate_tiles(const Options& o) {
  if (o.output.empty() && o.map.empty() && o.picture.empty())
    throw ArgumentError("there is nothing to write", "give --output, --map or --picture");
  const TileAllocation solved = o.tiles.solve(o.tiles.read_buffers());
  if (!o.map.empty()) write_shading_rate_map(o.map, solved.map);
  if (!o.picture.empty())
    write_picture_png(
        o.picture,
        rate_map_picture(solved.map, fmt::format("Shading rates at {:g} % of full rate ({})",
                                                 100 * o.tiles.budget, o.tiles.solver)));
  if (!o.output.empty())
    write_allocation(o.output, o.tiles.solver, solved.problem, solved.allocation);
  fmt::print("{}\n", describe(solved.problem, solved.allocation));
}

}  // namespace

void add_quality_allocate(CLI::App& quality) {
  auto* command = quality.add_subcommand(
      "allocate", "Shading rate of each tile for the best quality within a budget");
  auto options = std::make_shared<Options>();
  command->add_option("--input", options->input, "JSON: an allocation problem, instead of tiles");
  command->add_option("--instance", options->instance, "the one of this name, in a list of them");
  options->tiles.add_to(*command);
  command->add_option("--solver", options->tiles.solver, "greedy, exact or fast")
      ->capture_default_str();
  command->add_option("--output", options->output, "JSON: choice, quality, cost, bound");
  command->add_option("--map", options->map, "EXR: rate index of each tile");
  command->add_option("--picture", options->picture, "PNG: the map in colours");
  command->footer(
      "Examples:\n"
      "  wheatstone quality allocate --input ../shared/reference/perception/vectors/"
      "knapsack_instances.json --instance ties_4x4 --solver exact --output out/choice.json\n"
      "  wheatstone quality allocate --motion ../shared/reference/perception/sample_frame/"
      "motion_n.exr --materials ../shared/reference/perception/sample_frame/materials_n.exr "
      "--polynomials ../shared/reference/perception/vectors/sample_polynomials.csv --budget 0.25 "
      "--map out/rates.exr --picture out/rates.png");
  command->callback([=] {
    if (options->input.empty())
      allocate_tiles(*options);
    else
      allocate_instance(*options);
  });
}

}  // namespace wheatstone::apps
