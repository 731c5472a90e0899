#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/commands.h"
#include "apps/commands/common.h"
#include "apps/import.h"
#include "core/error.h"

namespace wheatstone::apps {

void add_import(CLI::App& app) {
  auto* command = app.add_subcommand("import",
                                     "Real input: a stereo frame with depth (EXR), or "
                                     "posed pictures");
  auto input = std::make_shared<std::string>();
  auto folder = std::make_shared<std::string>();
  auto options = std::make_shared<ImportOptions>();
  command->add_option("input", *input, "file or folder")->required();
  command->add_option("--out", *folder, "new dataset folder")->required();
  command
      ->add_option("--format", options->format,
                   "auto, exr-stereo, light-field-renderer, colmap, nerf, llff or poses")
      ->capture_default_str();
  command
      ->add_option("--white-cd-m2", options->white_cd_m2,
                   "luminance of full white, or of 1 in an EXR that does not say")
      ->capture_default_str();
  command
      ->add_option("--mm-per-unit", options->mm_per_unit,
                   "length of the input's unit; 0: chosen as documented")
      ->capture_default_str();
  command->add_option("--hfov-deg", options->hfov_deg, "stereo EXR: field of view of the width")
      ->capture_default_str();
  command->add_option("--convention", options->convention,
                      "of nerf and llff poses if not the format's, as in 'opencv camera-to-world'");
  command->footer("Example:\n  wheatstone import ../shared/data/lightfield_shop --out out/shop");
  command->callback([=] { fmt::print("{}\n", import_input(*input, Dataset(*folder), *options)); });
}

}  // namespace wheatstone::apps
