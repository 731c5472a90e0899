#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>

#include "apps/commands/quality.h"
#include "apps/commands/tile_options.h"
#include "apps/shading_rate_pictures.h"
#include "core/error.h"
#include "core/files.h"
#include "core/png.h"
#include "rendering/motion_quality/gl/coarse_shading.h"
#include "rendering/motion_quality/gl/shading_rate_pass.h"

namespace wheatstone::apps {
namespace {

struct Options {
  std::string out, picture;
  std::vector<int> from_tile = {0, 0};
  double white_cd_m2 = 300;
  bool cpu = false;
  TileOptions tiles;
};

double total_quality(const AllocationProblem& problem, std::uint8_t rate_index) {
  double sum = 0;
  for (std::size_t tile = 0; tile < problem.tiles(); ++tile)
    sum += problem.quality[tile * kShadingRateCount + rate_index - 1];
  return sum;
}

/// The one rate for all tiles that is best within the budget.
std::uint8_t best_uniform_rate(const AllocationProblem& problem) {
  std::uint8_t best = 1;
  for (int k = 1; k < kShadingRateCount; ++k) {
    const auto index = static_cast<std::uint8_t>(k + 1);
    if (problem.cost[k] * static_cast<std::int64_t>(problem.tiles()) <= problem.budget &&
        total_quality(problem, index) > total_quality(problem, best))
      best = index;
  }
  return best;
}

/// The part of the frame that the picture shows, at full, uniform and allocated rates.
cv::Mat3b comparison(const Options& o, const TileBuffers& frame, const RgbImage& picture) {
  const cv::Size tiles = tile_count(picture.width(), picture.height());
  TileBuffers part = frame.part({{o.from_tile[0], o.from_tile[1]}, tiles});
  part.luminance_cd_m2 = tile_luminance_cd_m2(picture);
  const auto [problem, allocation, map] = o.tiles.solve(part);
  const std::uint8_t uniform = best_uniform_rate(problem);

  std::optional<OffscreenContext> context;
  if (!o.cpu) context.emplace();
  const auto shaded = [&](const ShadingRateMap& rates, const std::string& name, double quality) {
    const RgbImage light = context ? ShadingRatePass(*context).shade_picture(picture, rates)
                                   : shade_picture_coarsely(picture, rates);
    return ShadedPicture{
        to_srgb8(light, o.white_cd_m2), rates,
        fmt::format("{}: quality {:.1f}, {} shades", name, quality, rates.cost_px())};
  };
  return side_by_side({shaded(ShadingRateMap{cv::Mat1b(tiles, uniform)},
                              std::string("uniform ") + kShadingRates[uniform - 1].name,
                              total_quality(problem, uniform)),
                       shaded(map, "allocated", allocation.total_quality)},
                      fmt::format("The same budget: {:g} % of full rate; quality in model units",
                                  100 * o.tiles.budget));
}

void write_maps(const Options& o) {
  const TileBuffers buffers = o.tiles.read_buffers();
  const auto [problem, allocation, map] = o.tiles.solve(buffers);
  cv::Mat3b compared;
  if (!o.picture.empty())
    compared = comparison(o, buffers, read_srgb_picture(o.picture, o.white_cd_m2));

  const std::filesystem::path folder = o.out;
  make_folder(folder);
  write_shading_rate_map(folder / "rates.exr", map);
  write_picture_png(folder / "rates.png",
                    rate_map_picture(map, fmt::format("Shading rates at {:g} % of full rate",
                                                      100 * o.tiles.budget)));
  write_picture_png(
      folder / "quality.png",
      quality_map_picture(
          problem.quality, map,
          fmt::format("Quality above 4x4 shading, {:g} % of full rate", 100 * o.tiles.budget)));
  if (!compared.empty()) write_picture_png(folder / "comparison.png", compared);
  fmt::print("{}\n", describe(problem, allocation));
}

}  // namespace

void add_quality_map(CLI::App& quality) {
  auto* command = quality.add_subcommand(
      "map",
      "Pictures of an allocation: rates, quality, and the frame at uniform and at "
      "allocated rates");
  auto options = std::make_shared<Options>();
  command->add_option("--out", options->out, "folder for the pictures")->required();
  options->tiles.add_to(*command);
  command->add_option("--solver", options->tiles.solver, "greedy, exact or fast")
      ->capture_default_str();
  command->add_option("--picture", options->picture,
                      "the frame at full rate, or a part of it (sRGB); its luminance replaces "
                      "the tiles' in the comparison");
  command->add_option("--from-tile", options->from_tile, "x and y of the part's first tile")
      ->expected(2)
      ->capture_default_str();
  command->add_option("--white-cd-m2", options->white_cd_m2, "luminance of the picture's white")
      ->capture_default_str();
  command->add_flag("--cpu", options->cpu, "the shader's CPU twin instead of OpenGL");
  command->footer(
      "Example:\n  wheatstone quality map --motion ../shared/reference/perception/sample_frame/"
      "motion_n.exr --materials ../shared/reference/perception/sample_frame/materials_n.exr "
      "--polynomials ../shared/reference/perception/vectors/sample_polynomials.csv --budget 0.25 "
      "--picture ../shared/reference/perception/sample_frame/scene_snapshot.png --from-tile 8 22 "
      "--out out/map");
  command->callback([=] { write_maps(*options); });
}

}  // namespace wheatstone::apps
