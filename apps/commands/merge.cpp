#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/commands.h"
#include "apps/commands/common.h"
#include "apps/stations.h"
#include "core/error.h"

namespace wheatstone::apps {

void add_merge(CLI::App& app) {
  auto* command = app.add_subcommand("merge", "Merge raw exposures to HDR views in cd/m2");
  auto folder = std::make_shared<std::string>();
  command->add_option("dataset", *folder, "dataset folder")->required();
  command->footer("Example:\n  wheatstone merge out/card");
  command->callback([=] { merge(open_dataset(*folder), show_progress); });
}

}  // namespace wheatstone::apps
