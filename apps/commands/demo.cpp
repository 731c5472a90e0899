#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/commands.h"
#include "apps/commands/common.h"
#include "apps/demo.h"
#include "core/error.h"

namespace wheatstone::apps {

void add_demo(CLI::App& app) {
  auto* command = app.add_subcommand("demo", "The whole way on the simulated rig, with a report");
  auto options = std::make_shared<DemoOptions>();
  auto real = std::make_shared<std::string>();
  command->add_option("--out", options->out, "folder for report.html and summary.json")
      ->capture_default_str();
  command->add_option("--real", *real, "folder with the real input sets");
  command->add_option("--scene", options->scenes, "scenes to run")->capture_default_str();
  command->add_option("--scale", options->scale, "of all pixel counts")->capture_default_str();
  command->add_option("--seed", options->seed, "of everything random")->capture_default_str();
  auto chaos = std::make_shared<ChaosOption>();
  chaos->add_to(*command);
  command->footer("Example:\n  wheatstone demo --out out/demo");
  command->callback([=] {
    if (!real->empty()) options->real_data = *real;
    options->fault_probability = chaos->probability();
    run_demo(*options, show_progress);
    fmt::print("{}\n{}\n", (options->out / "report.html").string(),
               (options->out / "summary.json").string());
  });
}

}  // namespace wheatstone::apps
