#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <opencv2/core.hpp>
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

// Left-out patches off by more: a chart worth a look, and one that calibrates nothing.
constexpr double kDoubtfulRms = 0.05, kUselessRms = 0.3;
constexpr double kDoubtfulScale = 4;  // of the camera's own sensitivity, either way

/// R, G, B as stored. They are camera colours, not light: beside the patches they may be negative.
cv::Mat3f read_camera_colours(const std::filesystem::path& file) {
  const std::vector<ExrView> views = read_exr_views(file);
  std::vector<cv::Mat1f> planes;
  for (const char* name : {"R", "G", "B"}) {
    const auto channel = views.front().channels.find(name);
    if (channel == views.front().channels.end())
      throw FileError(file, std::string("has no channel ") + name,
                      "merge the chart's frames without --no-demosaic");
    planes.push_back(channel->second.pixels);
  }
  cv::Mat3f picture;
  cv::merge(planes, picture);
  return picture;
}

/// Errors: ArgumentError, beginning with `patch`, for samples that are not finite or no light.
Eigen::Vector3d mean_of(const cv::Mat3f& picture, const cv::Rect& area, const std::string& patch) {
  if (!cv::checkRange(picture(area)))
    throw ArgumentError(patch + " has samples that are not finite", "merge the chart again");
  const cv::Scalar mean = cv::mean(picture(area));
  if (!(mean[0] + mean[1] + mean[2] > 0))
    throw ArgumentError(patch + " is black in the picture",
                        "check its rectangle, or expose the chart longer");
  return {mean[0], mean[1], mean[2]};
}

std::vector<NamedPatch> read_patches(const CsvTable& table, const cv::Mat3f& picture) {
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
        (area & cv::Rect(0, 0, picture.cols, picture.rows)) != area)
      throw ArgumentError(table.where(i) + ": the patch reaches out of the picture of " +
                              fmt::format("{} x {} px", picture.cols, picture.rows),
                          "give the patch's rectangle in pixels of the picture");
    const Eigen::Vector3d xyz(table.finite_number(i, "X_cd_m2"), table.finite_number(i, "Y_cd_m2"),
                              table.finite_number(i, "Z_cd_m2"));
    const std::string name = table.text(i, "patch");
    const std::string where = table.where(i) + ": patch " + name;
    if (!(xyz.y() > 0) || xyz.minCoeff() < 0)
      throw ArgumentError(
          fmt::format("{} has X, Y, Z of {}, {}, {} cd/m²", where, xyz.x(), xyz.y(), xyz.z()),
          "measure it again: light is not negative, and Y is above 0");
    out.push_back({name, {mean_of(picture, area, where), rgb_from_xyz * xyz}});
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

/// How far the luminance of each patch is off: fitted, and predicted without it (where at least
/// four others remain).
struct PatchError {
  double fitted = 0;
  std::optional<double> left_out;
  double counted() const { return left_out.value_or(fitted); }
};

/// Which patches a misfit comes from.
std::string suspects(const std::vector<NamedPatch>& patches,
                     const std::vector<PatchError>& errors) {
  if (const auto pair = swapped_patches(without(patches, patches.size())))
    return fmt::format("the readings of {} and {} seem to be swapped", patches[pair->first].name,
                       patches[pair->second].name);
  std::vector<std::size_t> order(patches.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::abs(errors[a].counted()) > std::abs(errors[b].counted());
  });
  order.resize(std::min<std::size_t>(3, order.size()));
  std::string worst;
  for (const std::size_t i : order)
    worst += fmt::format("{}{} ({:+.1f} %)", worst.empty() ? "" : ", ", patches[i].name,
                         100 * errors[i].counted());
  return "the worst are " + worst + ": swapped, glossy or misplaced?";
}

void calibrate_colour(const Options& o) {
  const CsvTable table = CsvTable::read(o.patches);
  const std::vector<NamedPatch> patches = read_patches(table, read_camera_colours(o.picture));
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
  const double sensitivity_before = camera.dn_per_cd_m2_s;
  set_colour_response(camera, M);

  std::vector<PatchError> errors;
  double sum2 = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const ChartPatch& patch = patches[i].patch;
    const auto error_under = [&](const Eigen::Matrix3d& matrix) {
      return luminance(matrix * patch.camera_rgb) / luminance(patch.reference) - 1;
    };
    PatchError error{error_under(M), std::nullopt};
    if (patches.size() > 4)
      error.left_out =
          error_under(fit_colour_matrix(without(patches, i), ChartWeighting::kRelative));
    errors.push_back(error);
    sum2 += std::pow(error.counted(), 2) / static_cast<double>(patches.size());
  }
  const double rms = std::sqrt(sum2);
  const std::string misfit =
      fmt::format("the patches' luminances are off by {:.1f} % RMS", 100 * rms);
  if (rms > kUselessRms)
    throw FileError(o.patches, misfit,
                    suspects(patches, errors) + "; check rectangles and readings");
  if (rms > kDoubtfulRms)
    fmt::print(stderr, "warning: {}; {}\n", misfit, suspects(patches, errors));
  const double change = camera.dn_per_cd_m2_s / sensitivity_before;
  if (change > kDoubtfulScale || change < 1 / kDoubtfulScale)
    fmt::print(stderr,
               "warning: by these readings the camera is {:.3g} times as sensitive as {} says; are "
               "they in cd/m², and the picture in DN/s at ISO 100?\n",
               change, o.camera);

  nlohmann::json rows = nlohmann::json::array();
  for (std::size_t i = 0; i < patches.size(); ++i)
    rows.push_back({{"patch", patches[i].name},
                    {"luminance_cd_m2", luminance(patches[i].patch.reference)},
                    {"relative_error", errors[i].fitted},
                    {"relative_error_left_out",
                     errors[i].left_out ? nlohmann::json(*errors[i].left_out) : nlohmann::json()}});
  write_camera_profile(o.out, camera);
  if (o.as_json) {
    fmt::print("{}\n", nlohmann::json{{"schema", "wheatstone-colour/1"},
                                      {"bt709_from_camera", to_json(Eigen::MatrixXd(M))},
                                      {"patches", rows}}
                           .dump(2));
    return;
  }
  for (const auto& row : rows)
    fmt::print("{:16} {:10.4g} cd/m² {:+7.2f} %{}\n", row["patch"].get<std::string>(),
               row["luminance_cd_m2"].get<double>(), 100 * row["relative_error"].get<double>(),
               row["relative_error_left_out"].is_null()
                   ? ""
                   : fmt::format(", left out {:+7.2f} %",
                                 100 * row["relative_error_left_out"].get<double>()));
  if (patches.size() > 4) {
    const auto worst = std::max_element(errors.begin(), errors.end(),
                                        [](const PatchError& a, const PatchError& b) {
                                          return std::abs(a.counted()) < std::abs(b.counted());
                                        });
    fmt::print("luminance of patches left out: {:.2f} % RMS, worst {} with {:.2f} %\n", 100 * rms,
               patches[static_cast<std::size_t>(worst - errors.begin())].name,
               100 * std::abs(worst->counted()));
  }
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
  command->add_flag("--json", o->as_json, "the result as JSON on standard output");
  command->footer(
      "Example:\n  wheatstone calibrate colour --picture chart.exr --patches chart.csv --camera "
      "out/card/camera.json --out camera.json");
  command->callback([o] { calibrate_colour(*o); });
}

}  // namespace wheatstone::apps
