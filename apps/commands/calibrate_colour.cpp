#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "apps/commands/commands.h"
#include "calib/colour_calibration.h"
#include "core/colour.h"
#include "core/csv.h"
#include "core/dataset.h"
#include "core/error.h"
#include "core/exr.h"
#include "core/json.h"

namespace wheatstone::apps {
namespace {

struct Options {
  std::string picture, patches, camera, out, reference_patch;
  bool as_json = false;
};

struct NamedPatch {
  std::string name;
  ChartPatch patch;  // reference: BT.709 in cd/m^2
};

Eigen::Vector3d mean_of(const RgbImage& picture, const cv::Rect& area) {
  const cv::Scalar mean = cv::mean(picture.pixels(area));
  return {mean[0], mean[1], mean[2]};
}

std::vector<NamedPatch> read_patches(const CsvTable& table, const RgbImage& picture) {
  const Eigen::Matrix3d rgb_from_xyz = xyz_from_rgb(bt709_primaries()).inverse();
  std::vector<NamedPatch> out;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    std::array<int, 4> side{};
    const std::array<const char*, 4> names = {"x_px", "y_px", "width_px", "height_px"};
    for (std::size_t k = 0; k < 4; ++k) {
      const double value = table.finite_number(i, names[k]);
      if (value != std::round(value) || std::abs(value) > 1e6)
        throw ArgumentError(table.where(i) + ": " + names[k] + " is no whole number of pixels",
                            "give the patch's rectangle in pixels of the picture");
      side[k] = static_cast<int>(value);
    }
    const cv::Rect area(side[0], side[1], side[2], side[3]);
    if (area.width < 1 || area.height < 1 ||
        (area & cv::Rect(0, 0, picture.width(), picture.height())) != area)
      throw ArgumentError(table.where(i) + ": the patch reaches out of the picture of " +
                              fmt::format("{} x {} px", picture.width(), picture.height()),
                          "give the patch's rectangle in pixels of the picture");
    const Eigen::Vector3d xyz(table.finite_number(i, "X_cd_m2"), table.finite_number(i, "Y_cd_m2"),
                              table.finite_number(i, "Z_cd_m2"));
    out.push_back({table.text(i, "patch"), {mean_of(picture, area), rgb_from_xyz * xyz}});
  }
  return out;
}

double luminance(const Eigen::Vector3d& bt709) {
  return xyz_from_rgb(bt709_primaries()).row(1).dot(bt709);
}

std::vector<ChartPatch> without(const std::vector<NamedPatch>& patches, std::size_t left_out) {
  std::vector<ChartPatch> out;
  for (std::size_t i = 0; i < patches.size(); ++i)
    if (i != left_out) out.push_back(patches[i].patch);
  return out;
}

void calibrate_colour(const Options& o) {
  const CsvTable table = CsvTable::read(o.patches);
  const std::vector<NamedPatch> patches = read_patches(table, read_exr(o.picture));
  CameraProfile camera = read_camera_profile(o.camera);
  Eigen::Matrix3d M =
      fit_colour_matrix(without(patches, patches.size()), ChartWeighting::kRelative);
  if (!o.reference_patch.empty()) {
    const auto it = std::find_if(patches.begin(), patches.end(),
                                 [&](const NamedPatch& p) { return p.name == o.reference_patch; });
    if (it == patches.end())
      throw ArgumentError("the chart has no patch named " + o.reference_patch,
                          "use a name of the column patch in " + o.patches);
    M = scaled_to_patch(M, it->patch);
  }
  set_colour_response(camera, M);

  // How far off a patch is that the matrix has not seen.
  nlohmann::json rows = nlohmann::json::array();
  double sum2 = 0, worst = 0;
  std::string worst_name;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const auto& [name, patch] = patches[i];
    const double measured = luminance(patch.reference);
    const double fitted = luminance(M * patch.camera_rgb) / measured - 1;
    std::optional<double> unseen;
    if (patches.size() > 4) {
      const Eigen::Matrix3d other =
          fit_colour_matrix(without(patches, i), ChartWeighting::kRelative);
      unseen = luminance(other * patch.camera_rgb) / measured - 1;
      sum2 += *unseen * *unseen;
      if (std::abs(*unseen) > worst) {
        worst = std::abs(*unseen);
        worst_name = name;
      }
    }
    rows.push_back({{"patch", name},
                    {"luminance_cd_m2", measured},
                    {"relative_error", fitted},
                    {"relative_error_left_out", unseen ? nlohmann::json(*unseen) : nullptr}});
  }
  write_camera_profile(o.out, camera);
  if (o.as_json) {
    fmt::print("{}\n", nlohmann::json{{"schema", "wheatstone-colour/1"},
                                      {"bt709_from_camera", to_json(Eigen::MatrixXd(M))},
                                      {"patches", rows}}
                           .dump(2));
    return;
  }
  for (const auto& row : rows)
    fmt::print("{:16} {:10.4g} cd/m^2 {:+7.2f} %{}\n", row["patch"].get<std::string>(),
               row["luminance_cd_m2"].get<double>(), 100 * row["relative_error"].get<double>(),
               row["relative_error_left_out"].is_null()
                   ? ""
                   : fmt::format(", left out {:+7.2f} %",
                                 100 * row["relative_error_left_out"].get<double>()));
  if (patches.size() > 4)
    fmt::print("luminance of patches left out: {:.2f} % RMS, worst {} with {:.2f} %\n",
               100 * std::sqrt(sum2 / static_cast<double>(patches.size())), worst_name,
               100 * worst);
  fmt::print("wrote {}\n", o.out);
}

}  // namespace

void add_calibrate_colour(CLI::App& calibrate) {
  auto* command = calibrate.add_subcommand(
      "colour", "The camera's response to light, from a chart measured with a spectroradiometer");
  auto o = std::make_shared<Options>();
  command
      ->add_option("--picture", o->picture,
                   "EXR of the chart in camera colours, as merge --frames writes it")
      ->required();
  command->add_option("--patches", o->patches, "CSV (docs/colour_calibration.md)")->required();
  command->add_option("--camera", o->camera, "camera.json whose geometry and noise are kept")
      ->required();
  command->add_option("--reference-patch", o->reference_patch,
                      "the patch whose luminance is met exactly");
  command->add_option("--out", o->out, "camera.json with the new response")->required();
  command->add_flag("--json", o->as_json, "one JSON object on standard output");
  command->footer(
      "Example:\n  wheatstone calibrate colour --picture chart.exr --patches chart.csv --camera "
      "out/card/camera.json --out camera.json");
  command->callback([o] { calibrate_colour(*o); });
}

}  // namespace wheatstone::apps
