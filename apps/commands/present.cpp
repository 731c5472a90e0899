#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>

#include "apps/check.h"
#include "apps/commands/commands.h"
#include "apps/commands/common.h"
#include "apps/stations.h"
#include "core/error.h"
#include "core/text.h"

namespace wheatstone::apps {

void add_present(CLI::App& app) {
  auto* command = app.add_subcommand("present", "Split to eight drive frames and show them");
  auto folder = std::make_shared<std::string>();
  auto scale = std::make_shared<double>(0.25);
  command->add_option("dataset", *folder, "dataset folder, rendered")->required();
  command->add_option("--scale", *scale, "of the simulated displays, for imported input")
      ->capture_default_str();
  auto limit = std::make_shared<std::optional<double>>();
  command
      ->add_option("--luminance-limit", *limit,
                   "refuse frames that could show an eye more, in cd/m²")
      ->check(CLI::PositiveNumber);
  auto chaos = std::make_shared<ChaosOption>();
  chaos->add_to(*command);
  command->footer("Example:\n  wheatstone present out/card");
  command->callback([=] {
    const Dataset dataset = open_dataset(*folder);
    const PresentReport r = split_to_drive_frames(dataset);
    fmt::print("eight frames in {}; {} too bright, {} too dark for the displays\n",
               dataset.file("drive").string(), counted(r.above_peak_px, "pixel"), r.below_black_px);
    SimulatedRig twin(twin_of(dataset, *scale));
    chaos->arm(&twin);
    Rig rig = twin.rig();
    if (*limit) rig.luminance_limit = Luminance::of(**limit);
    if (dataset.read_manifest().kind == "capture") {
      const auto checks = check_at_eye(dataset, twin, rig.luminance_limit);
      fmt::print("PU21-PSNR at the eye: left {:.2f} dB, right {:.2f} dB\n", checks[0].pu21_psnr_db,
                 checks[1].pu21_psnr_db);
    } else {
      present(dataset, rig);
    }
  });
}

}  // namespace wheatstone::apps
