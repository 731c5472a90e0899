#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/quality.h"
#include "apps/commands/quality_options.h"
#include "core/error.h"
#include "rendering/motion_quality/camojab.h"
#include "rendering/motion_quality/grey_texture.h"

namespace wheatstone::apps {
namespace {

constexpr std::string_view kProcedural = "procedural:";

cv::Mat1d texture_named(const std::string& name) {
  return name.starts_with(kProcedural) ? procedural_texture(name.substr(kProcedural.size()))
                                       : read_grey_texture(name);
}

CamojabConditions conditions_in(const CsvTable& t, std::size_t row) {
  const auto value = [&](const char* column) { return t.finite_number(row, column); };
  const CamojabConditions c{value("ppd"),
                            value("refresh_hz"),
                            value("velocity_deg_s"),
                            value("persistence"),
                            value("mean_lum_cd_m2"),
                            value("mip_level"),
                            value("srx"),
                            value("sry")};
  require_valid(c);
  return c;
}

}  // namespace

void add_quality_camojab(CLI::App& quality) {
  auto* command = quality.add_subcommand(
      "camojab", "CaMoJAB: spatial and temporal distortion Ds, Dt and quality Q of a texture");
  auto texture = std::make_shared<std::string>();
  auto table = std::make_shared<TableOptions>();
  auto preset = std::make_shared<std::string>("released");
  command
      ->add_option("--texture", *texture,
                   "EXR with channel Y or R, G, B, an 8- or 16-bit picture, or procedural:NAME")
      ->required();
  table->add_to(*command);
  add_preset_option(*command, *preset);
  command->footer(
      "Columns: ppd, refresh_hz, velocity_deg_s, persistence, mean_lum_cd_m2, mip_level, srx, sry\n"
      "(shading rates along and across the motion, (0, 1]).\n"
      "Example:\n  wheatstone quality camojab --texture procedural:checker512 "
      "--input ../shared/reference/perception/vectors/camojab_vectors.csv --output "
      "out/quality.csv");
  command->callback([=] {
    const CamojabModel model = CamojabModel::preset(motion_quality_preset_from_string(*preset));
    CsvTable t = CsvTable::read(table->input);
    std::vector<CamojabConditions> conditions(t.rows());
    for_each_row(t, [&](std::size_t row) { conditions[row] = conditions_in(t, row); });
    const Camojab camojab(CamojabTexture(texture_named(*texture)), model);
    std::vector<double> ds, dt, q;
    for (const CamojabQuality& result : camojab.evaluate(conditions)) {
      ds.push_back(result.spatial_distortion);
      dt.push_back(result.temporal_distortion);
      q.push_back(result.quality);
    }
    t.set_column("Ds", ds);
    t.set_column("Dt", dt);
    t.set_column("Q", q);
    table->finish(t);
  });
}

}  // namespace wheatstone::apps
