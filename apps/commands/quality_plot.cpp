#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/quality.h"
#include "apps/commands/quality_options.h"
#include "apps/quality_figures.h"
#include "core/error.h"
#include "rendering/motion_quality/grey_texture.h"

namespace wheatstone::apps {
namespace {

RefreshTable refresh_table(const std::string& texture, MotionQualityPreset preset) {
  if (texture.empty()) throw ArgumentError("figure 6.4 needs a texture", "give --texture");
  const double budgets[] = {0.0625, 0.125, 0.25, 0.5};
  const double speeds_deg_per_s[] = {0, 5, 10, 15, 20, 30, 40, 50};
  return {Camojab(CamojabTexture(read_grey_texture(texture)), CamojabModel::preset(preset)),
          budgets, speeds_deg_per_s};
}

}  // namespace

void add_quality_plot(CLI::App& quality) {
  auto* command = quality.add_subcommand("plot", "Figures of the models as SVG");
  auto figure = std::make_shared<std::string>();
  auto texture = std::make_shared<std::string>();
  auto output = std::make_shared<std::string>();
  auto preset = std::make_shared<std::string>("released");
  auto options = std::make_shared<ExperimentOptions>();
  command
      ->add_option("figure,--figure", *figure,
                   "3.4: MARRR's best refresh rate and resolution over speed; 5.6: CaMoJAB and the "
                   "shading-rate measurements; 5.7: CaMoJAB and the refresh-rate measurements; "
                   "6.4: ALSaRR's "
                   "best refresh rate over speed")
      ->required();
  command->add_option("--texture", *texture, "6.4: what moves, an EXR or a picture");
  command->add_option("--output", *output, "SVG to write")->required();
  add_preset_option(*command, *preset);
  options->add_to(*command);
  command->footer("Example:\n  wheatstone quality plot 3.4 --output out/best_refresh_rate.svg");
  command->callback([=] {
    const MotionQualityPreset chosen = motion_quality_preset_from_string(*preset);
    if (*figure == "3.4")
      write_svg(*output, marrr_optimum_figure(chosen), 2);
    else if (*figure == "5.6")
      write_svg(*output, shading_rate_figure(options->read(), chosen), 4);
    else if (*figure == "5.7")
      write_svg(*output, refresh_rate_figure(options->read(), chosen), 3);
    else if (*figure == "6.4")
      write_svg(*output, refresh_table_figure(refresh_table(*texture, chosen)), 2);
    else
      throw ArgumentError("'" + *figure + "' is no figure", "use 3.4, 5.6, 5.7 or 6.4");
  });
}

}  // namespace wheatstone::apps
