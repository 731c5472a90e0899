#include "apps/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/stations.h"
#include "capture/import/colmap.h"
#include "capture/import/light_field_renderer.h"
#include "capture/import/llff.h"
#include "capture/import/nerf.h"
#include "capture/import/poses_json.h"
#include "capture/import/stereo_rgbd.h"
#include "core/error.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/text.h"
#include "core/units.h"

namespace wheatstone::apps {

namespace fs = std::filesystem;

namespace {

constexpr double kWidestDeg = 170;  // a flat picture of more has hardly any pixels in the middle

bool has_colmap(const fs::path& folder) {
  return fs::exists(folder / "cameras.txt") || fs::exists(folder / "cameras.bin");
}

/// The list of poses in a folder: of other programs and merged captures poses.json, else what a
/// dataset renders from.
fs::path poses_file(const fs::path& folder) {
  for (const char* name : {"poses.json", "views.json"})
    if (fs::exists(folder / name)) return folder / name;
  return folder / "poses.json";
}

std::string guess_format(const fs::path& input) {
  if (!fs::exists(input)) throw FileError(input, "is missing", "check the path");
  if (fs::is_regular_file(input)) {
    if (input.extension() == ".exr") return "exr-stereo";
    if (input.extension() == ".json")
      return input.filename().string().starts_with("transforms") ? "nerf" : "poses";
  } else {
    if (has_colmap(input) || has_colmap(input / "colmap")) return "colmap";
    if (fs::exists(poses_file(input))) return "poses";
    if (fs::exists(input / "transforms.json")) return "nerf";
    if (fs::exists(input / "poses_bounds.npy")) return "llff";
    if (fs::exists(input / "config.cfg")) return "light-field-renderer";
    if (fs::exists(input / "dataset.json"))
      throw FileError(input, "is a capture without poses",
                      "run `wheatstone merge` and `wheatstone calibrate poses` on it first");
  }
  throw FileError(input, "states no poses in a form this program knows",
                  std::string("add a poses.json with \"schema\": \"") + kPosesSchema +
                      "\" and \"convention\": \"" + kPoseConvention + "\", or name --format");
}

std::string import_views(const std::vector<ImportedView>& listed, const Dataset& dataset,
                         const ImportOptions& options, const std::string& note) {
  std::vector<LightFieldView> views;
  bool some_exr = false;
  for (const ImportedView& v : listed) {
    if (v.path.empty()) continue;
    some_exr = some_exr || v.path.extension() == ".exr";
    views.push_back(load_view(v, options.white_cd_m2));
    views.back().name = v.path.stem().string();
  }
  if (views.empty())
    throw ArgumentError("none of the posed pictures is there", "put the pictures beside the poses");
  store_light_field(dataset, views);
  return fmt::format("{}, full white = {} cd/m²{}{}", counted(views.size(), "posed view"),
                     options.white_cd_m2, some_exr ? " (EXR: where the file does not say)" : "",
                     note);
}

/// Which convention the poses have, and how well known points confirm it. Throws when they do not.
std::string verified(const fs::path& file, const std::vector<ImportedView>& views,
                     const std::vector<KnownPoint>& points, PoseConvention convention) {
  if (points.empty())
    return fmt::format(", poses {} (not verified: the input holds no known points)",
                       to_string(convention));
  return fmt::format(", poses {}, median reprojection error {:.2f} px of {}", to_string(convention),
                     require_convention(file, views, points, convention),
                     counted(points.size(), "known point"));
}

/// A folder that goes again if nothing was put into it.
class NewFolder {
 public:
  explicit NewFolder(fs::path folder) : folder_(std::move(folder)) {
    if (std::error_code error; fs::exists(folder_) && !fs::is_empty(folder_, error))
      throw FileError(folder_, "holds something already", "import into a new folder");
    make_folder(folder_);
  }
  ~NewFolder() {
    std::error_code not_empty;
    fs::remove(folder_, not_empty);
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

 private:
  fs::path folder_;
};

std::string not_there(const std::vector<std::string>& files) {
  if (files.empty()) return "";
  constexpr std::size_t kNamed = 8;
  return fmt::format(", not there: {}: {}{}", counted(files.size(), "posed picture"),
                     fmt::join(files.begin(), files.begin() + std::min(files.size(), kNamed), ", "),
                     files.size() > kNamed ? ", ..." : "");
}

void require_legal(const ImportOptions& options) {
  if (!(options.hfov_deg > 0 && options.hfov_deg < kWidestDeg))
    throw ArgumentError(
        fmt::format("--hfov-deg is {}, outside 0 to {} degrees", options.hfov_deg, kWidestDeg),
        "give the angle that the width of the stereo frame spans, as the program that rendered it "
        "states it; 13.2 if it is not given");
  if (!(options.white_cd_m2 > 0) || !std::isfinite(options.white_cd_m2))
    throw ArgumentError(fmt::format("--white-cd-m2 is {}", options.white_cd_m2),
                        "give the luminance of full white in cd/m², above 0; 100 is a usual "
                        "monitor's");
  if (!(options.mm_per_unit >= 0) || !std::isfinite(options.mm_per_unit))
    throw ArgumentError(fmt::format("--mm-per-unit is {}", options.mm_per_unit),
                        "give the length of the input's unit in mm, above 0, as in 1000 for "
                        "metres; 0 chooses it");
}

std::string import_stereo(const fs::path& input, const Dataset& dataset,
                          const ImportOptions& options, double& mm_per_unit) {
  const std::vector<ExrView> exr = read_exr_views(input);
  if (exr.size() == 1 && !exr[0].channels.contains("Z"))
    throw FileError(input, "is one picture without pose or depth",
                    "import the folder whose poses.json or views.json says where it was taken "
                    "from, as merge, calibrate and import leave it, or render a multi-view EXR "
                    "with the views left and right and their depth Z");
  const StereoRgbd frame = stereo_rgbd(exr, input);
  std::vector<float> depths;
  for (const EyeRgbd* e : {&frame.left, &frame.right})
    for (int r = 0; r < e->mask.rows; r += 4)
      for (int c = 0; c < e->mask.cols; c += 4)
        if (e->mask(r, c) != 0) depths.push_back(e->z_units.pixels(r, c));
  if (depths.empty()) throw FileError(input, "has no pixel with depth", "check the Z channel");
  std::nth_element(depths.begin(), depths.begin() + depths.size() / 2, depths.end());
  const double median = depths[depths.size() / 2];
  const double middle_mm = 2000 / (vergence_at(490.0_mm) + vergence_at(850.0_mm)).value();
  if (mm_per_unit == 0) mm_per_unit = middle_mm / median;

  const int width = frame.left.light.width(), height = frame.left.light.height();
  const double f = 0.5 * width / std::tan(options.hfov_deg * std::numbers::pi / 360);
  make_folder(dataset.file("depth"));
  std::vector<LightFieldView> views;
  for (const Eye eye : {Eye::kLeft, Eye::kRight}) {
    const EyeRgbd& e = eye == Eye::kLeft ? frame.left : frame.right;
    ScalarImage z_mm(cv::Mat1f(e.z_units.pixels * mm_per_unit));
    z_mm.pixels.setTo(0, e.mask == 0);
    write_exr(dataset.file("depth/" + to_string(eye) + ".exr"), z_mm, "Z");
    // The eyes stand 63 mm apart before the middle of the box. The principal points are shifted so
    // that the middle of the pictures is the middle of the far display for both eyes.
    const Eigen::Vector3d centre(eye == Eye::kLeft ? 153.5 : 216.5, 130, 850);
    const double shift = f * (185 - centre.x()) / 850;
    LightFieldView view;
    view.name = to_string(eye);
    view.light_cd_m2 = RgbImage(cv::Mat3f(e.light.pixels * options.white_cd_m2));
    view.intrinsics = {f, f, 0, (width - 1) / 2.0 - shift, (height - 1) / 2.0, width, height};
    view.T_camera_world = {straight_R_camera_rsb(), -(straight_R_camera_rsb() * centre)};
    views.push_back(view);
  }
  store_light_field(dataset, views);
  return fmt::format(
      "stereo frame {}x{}, value 1 = {} cd/m², {:.4g} mm per depth unit (median depth {:.0f} mm), "
      "{} deg wide",
      width, height, options.white_cd_m2, mm_per_unit, median * mm_per_unit, options.hfov_deg);
}

}  // namespace

std::string import_input(const fs::path& input, const Dataset& dataset,
                         const ImportOptions& options) {
  require_legal(options);
  const std::string format = options.format == "auto" ? guess_format(input) : options.format;
  std::optional<PoseConvention> convention;
  if (!options.convention.empty()) {
    convention = pose_convention_from_string(options.convention);
    if (format != "nerf" && format != "llff")
      throw ArgumentError("the convention of " + format + " poses is fixed",
                          "leave --convention out; it is for nerf and llff");
  }
  const NewFolder folder(dataset.root());
  double mm_per_unit = options.mm_per_unit;
  std::string line;
  if (format == "exr-stereo") {
    line = import_stereo(input, dataset, options, mm_per_unit);
  } else {
    if (mm_per_unit == 0) mm_per_unit = 1;
    if (format == "colmap") {
      const fs::path model = has_colmap(input) ? input : input / "colmap";
      const ColmapModel colmap = read_colmap(model, input / "images", mm_per_unit);
      line = import_views(colmap.views, dataset, options,
                          verified(model, colmap.views, known_points(colmap), kColmapConvention) +
                              not_there(colmap.missing_files));
    } else if (format == "nerf") {
      const fs::path file = fs::is_directory(input) ? input / "transforms.json" : input;
      const NerfModel nerf = read_nerf(file, mm_per_unit, convention);
      line = import_views(nerf.views, dataset, options,
                          verified(file, nerf.views, nerf.known_points, nerf.convention));
    } else if (format == "llff") {
      const LlffModel llff = read_llff(input, mm_per_unit, convention);
      line = import_views(llff.views, dataset, options,
                          verified(input, llff.views, {}, convention.value_or(kLlffConvention)));
    } else if (format == "light-field-renderer") {
      line = import_views(read_light_field_folder(input), dataset, options, "");
    } else if (format == "poses") {
      line = import_views(read_poses_json(fs::is_directory(input) ? poses_file(input) : input),
                          dataset, options, "");
    } else {
      throw ArgumentError(
          "'" + format + "' is no input format",
          "use auto, exr-stereo, light-field-renderer, colmap, nerf, llff or poses");
    }
  }
  DatasetManifest manifest;
  manifest.kind = format == "exr-stereo" ? "stereo-rgbd" : "light-field";
  manifest.scene = fs::absolute(input).stem().string();
  manifest.source = format;
  manifest.white_cd_m2 = options.white_cd_m2;
  manifest.mm_per_unit = mm_per_unit;
  dataset.write_manifest(manifest);
  return line;
}

}  // namespace wheatstone::apps
