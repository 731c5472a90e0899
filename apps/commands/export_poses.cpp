#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/commands.h"
#include "apps/commands/common.h"
#include "capture/import/colmap_writer.h"
#include "capture/import/llff.h"
#include "capture/import/nerf.h"
#include "capture/import/poses_json.h"
#include "core/error.h"
#include "core/files.h"

namespace wheatstone::apps {

void add_export_poses(CLI::App& app) {
  auto* command = app.add_subcommand("export-poses", "A dataset's poses for other programs");
  auto folder = std::make_shared<std::string>();
  auto format = std::make_shared<std::string>();
  auto out = std::make_shared<std::string>();
  auto distorted = std::make_shared<bool>(false);
  auto near_mm = std::make_shared<double>(190), far_mm = std::make_shared<double>(550);
  command->add_option("dataset", *folder, "dataset folder with views.json")->required();
  command->add_option("--format", *format, "colmap-text, colmap-binary, nerf or llff")
      ->check(CLI::IsMember({"colmap-text", "colmap-binary", "nerf", "llff"}))
      ->required();
  command->add_option("--out", *out, "new folder")->required();
  command->add_flag("--distorted", *distorted,
                    "the HDR views with their lens distortion (poses.json) instead of the cropped "
                    "ones");
  command->add_option("--near-mm", *near_mm, "nearest depth of the scene; the box's by default")
      ->capture_default_str();
  command->add_option("--far-mm", *far_mm, "farthest depth of the scene")->capture_default_str();
  command->footer("Example:\n  wheatstone export-poses out/card --format nerf --out out/card_nerf");
  command->callback([=] {
    const Dataset dataset = open_dataset(*folder);
    const auto source = dataset.file(*distorted ? "poses.json" : "views.json");
    const std::vector<ImportedView> views = read_poses_json(source);
    if (views.empty()) throw FileError(source, "holds no view", "calibrate or import some");
    const std::filesystem::path target = std::filesystem::absolute(*out);
    if (std::filesystem::exists(target) && !std::filesystem::is_empty(target))
      throw FileError(target, "is not empty", "choose a new folder");
    const std::vector<KnownPoint> points = check_points(views, *near_mm);
    PoseConvention convention = kColmapConvention;
    if (*format == "nerf") {
      make_folder(target);
      write_nerf(target / "transforms.json", views, points);
      convention = kNerfConvention;
    } else if (*format == "llff") {
      make_folder(target);
      write_llff(target / "poses_bounds.npy", views, *near_mm, *far_mm);
      convention = kLlffConvention;
    } else {
      write_colmap(target, *format == "colmap-binary", views, points);
    }
    fmt::print("{} {}, {}, in {}\n", views.size(), views.size() == 1 ? "pose" : "poses",
               to_string(convention), target.string());
  });
}

}  // namespace wheatstone::apps
