#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/commands.h"
#include "apps/commands/common.h"
#include "capture/session.h"
#include "core/error.h"
#include "core/files.h"

namespace wheatstone::apps {

void add_capture(CLI::App& app) {
  auto* command = app.add_subcommand("capture", "Capture a light field of the box");
  auto simulation = std::make_shared<SimulationOptions>();
  auto folder = std::make_shared<std::string>();
  auto plan = std::make_shared<CapturePlan>();
  command->add_option("dataset", *folder, "new dataset folder")->required();
  simulation->add_to(*command);
  command->add_option("--views", plan->views, "rail positions")->capture_default_str();
  command->add_option("--exposures", plan->exposures_s, "exposure times in s")
      ->capture_default_str();
  command->footer("Example:\n  wheatstone capture out/card --scene card --scale 0.1");
  command->callback([=] {
    const Dataset dataset(*folder);
    if (std::filesystem::exists(dataset.file("dataset.json")))
      throw FileError(dataset.root(), "holds a dataset already", "choose another folder");
    SimulatedRig twin({simulation->scene, simulation->scale, simulation->seed});
    make_folder(dataset.root());
    capture_light_field(twin.rig(), dataset, *plan,
                        [](int done, int total) { show_progress("capture", done, total); });
    dataset.write_manifest(
        {"capture", simulation->scene, simulation->seed, simulation->scale, "simulated rig", 0, 1});
  });
}

}  // namespace wheatstone::apps
