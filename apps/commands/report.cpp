#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/capture_report.h"
#include "apps/commands/commands.h"
#include "apps/commands/common.h"

namespace wheatstone::apps {

void add_report(CLI::App& app) {
  auto* command =
      app.add_subcommand("report", "What a capture holds and how far it can be trusted, as a page");
  auto folder = std::make_shared<std::string>();
  auto out = std::make_shared<std::string>();
  command->add_option("dataset", *folder, "dataset folder, captured")->required();
  command->add_option("--out", *out, "HTML file; report.html in the dataset folder if not given");
  command->footer("Example:\n  wheatstone report out/card");
  command->callback([=] {
    const Dataset dataset = open_dataset(*folder);
    const std::filesystem::path page =
        out->empty() ? dataset.file("report.html") : std::filesystem::path(*out);
    write_capture_report(dataset, page);
    fmt::print("{}\n", page.string());
  });
}

}  // namespace wheatstone::apps
