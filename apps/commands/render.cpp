#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/commands.h"
#include "apps/commands/common.h"
#include "apps/stations.h"
#include "core/error.h"
#include "core/exr.h"

namespace wheatstone::apps {

void add_render(CLI::App& app) {
  auto* command = app.add_subcommand("render",
                                     "What the four displays shall show, or a left-out "
                                     "view of a light field");
  auto folder = std::make_shared<std::string>();
  auto method = std::make_shared<std::string>("drlf");
  auto left_out = std::make_shared<std::string>();
  auto out = std::make_shared<std::string>();
  auto focus = std::make_shared<double>(0);
  auto cpu = std::make_shared<bool>(false);
  command->add_option("dataset", *folder, "dataset folder")->required();
  command->add_option("--method", *method, "drlf, or rgbd for an imported stereo frame")
      ->check(CLI::IsMember({"drlf", "rgbd"}))
      ->capture_default_str();
  command->add_option("--leave-out", *left_out, "render this view from all others and compare");
  command->add_option("--out", *out, "EXR for the left-out view");
  command->add_option("--focus-mm", *focus,
                      "focal plane: z in rsb for displays, distance from the camera with "
                      "--leave-out; found from the views when not given");
  command->add_flag("--cpu", *cpu, "the shader's CPU twin instead of OpenGL");
  command->footer(
      "Example:\n  wheatstone render out/shop --method drlf --leave-out "
      "shop_13_13_-0.000000_0.000000_30_36 --out out/shop_13_13.exr");
  command->callback([=] {
    const Dataset dataset = open_dataset(*folder);
    const auto plane =
        command->count("--focus-mm") > 0 ? std::optional<double>(*focus) : std::nullopt;
    if (!left_out->empty()) {
      const LeftOutReport r = render_left_out(dataset, *left_out, plane, !*cpu);
      if (!out->empty()) write_exr(*out, r.rendered);
      fmt::print(
          "focal plane {:.1f} mm\nDRLF {:.2f} dB\nnearest view {:.2f} dB ({})\naverage of "
          "two {:.2f} dB (with {})\n",
          r.focal_distance_mm, r.psnr_drlf_db, r.psnr_nearest_db, r.nearest, r.psnr_average_db,
          r.second);
      return;
    }
    const TargetReport r = *method == "rgbd" ? render_rgbd(dataset)
                                             : render_drlf(dataset, plane, !*cpu, show_progress);
    if (*method == "drlf")
      fmt::print("focal plane {:.1f} mm from the eye, {:.1f} % of the light on the near plane\n",
                 r.focal_distance_mm, 100 * r.near_weight);
  });
}

}  // namespace wheatstone::apps
