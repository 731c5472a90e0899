#include "apps/stations.h"

#include <algorithm>
#include <cmath>

#include "calib/eye_solver.h"
#include "calib/markers.h"
#include "capture/import/poses_json.h"
#include "capture/merge.h"
#include "capture/merged_exr.h"
#include "capture/rectify.h"
#include "core/error.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/json.h"
#include "core/png.h"

namespace wheatstone::apps {

namespace {

MergedMosaic merge_view(const Dataset& dataset, const CapturedView& view,
                        const CameraProfile& camera) {
  std::vector<RawExposure> stack;
  for (const ExposureRecord& e : view.exposures)
    stack.push_back(
        {read_mosaic_png(dataset.file(e.file), camera.pattern), Duration::of(e.exposure_s), 1});
  try {
    return merge_exposures(stack, merge_options(camera));
  } catch (const ArgumentError& e) {
    throw FileError(dataset.file("frames.json"), "view " + view.name + ": " + e.what(), "");
  }
}

}  // namespace

void merge(const Dataset& dataset, const Progress& progress, Shard shard) {
  const CameraProfile camera = dataset.read_camera();
  const std::vector<CapturedView> all = dataset.read_frames();
  std::vector<const CapturedView*> mine;
  for (std::size_t k = 0; k < all.size(); ++k)
    if (shard.holds(k)) mine.push_back(&all[k]);
  make_folder(dataset.file("hdr"));
  for (std::size_t i = 0; i < mine.size(); ++i) {
    const std::filesystem::path out = dataset.file("hdr/" + mine[i]->name + ".exr");
    if (!std::filesystem::exists(out))
      write_merged_light_exr(out, merge_view(dataset, *mine[i], camera), camera);
    progress("merge", static_cast<int>(i) + 1, static_cast<int>(mine.size()));
  }
}

PoseSolution calibrate_poses(const Dataset& dataset, const Progress& progress) {
  const CameraProfile camera = dataset.read_camera();
  const std::vector<CapturedView> frames = dataset.read_frames();
  const std::vector<Eigen::Vector3d> markers = dataset.read_landmarks().markers_mm;
  std::vector<std::vector<Eigen::Vector2d>> seen;
  for (const CapturedView& view : frames) {
    const MosaicImage frame = read_mosaic_png(dataset.file(view.marker_frame.file), camera.pattern);
    const auto centres =
        order_markers(find_markers(frame, camera), dataset.file(view.marker_frame.file).string());
    seen.emplace_back(centres.begin(), centres.end());
  }
  const PoseSolution solution = solve_poses(markers, seen, camera.intrinsics, camera.distortion);

  std::vector<ImportedView> posed;
  for (std::size_t i = 0; i < frames.size(); ++i)
    posed.push_back({frames[i].name, dataset.file("hdr/" + frames[i].name + ".exr"),
                     camera.intrinsics, camera.distortion, solution.T_camera_rsb[i]});
  write_poses_json(dataset.file("poses.json"), posed);

  const CommonBox box;
  const cv::Size size = common_size(camera.intrinsics, solution.T_camera_rsb, box);
  make_folder(dataset.file("views"));
  std::vector<ImportedView> cropped;
  for (std::size_t i = 0; i < posed.size(); ++i) {
    const LightFieldView view =
        rectify_to_common_box(posed[i].name, read_exr(posed[i].path), camera.intrinsics,
                              camera.distortion, posed[i].T_camera_world, box, size);
    const std::filesystem::path file = dataset.file("views/" + view.name + ".exr");
    write_exr(file, view.light_cd_m2, ExrPrecision::kHalf);
    cropped.push_back({view.name, file, view.intrinsics, {}, view.T_camera_world});
    progress("crop", static_cast<int>(i) + 1, static_cast<int>(posed.size()));
  }
  write_poses_json(dataset.file("views.json"), cropped);
  return solution;
}

std::vector<EyeDisplayCalibration> calibrate_eyes(const Dataset& dataset) {
  const std::vector<std::vector<Alignment>> marks = dataset.read_alignments();
  const std::vector<PanelModel> panels = dataset.read_displays();
  std::vector<EyeDisplayCalibration> eyes;
  for (DisplayId id : kDisplays) {
    const PanelModel& panel = panels[index_of(id)];
    try {
      eyes.push_back(
          solve_eye_display(id, marks[index_of(id)], panel.lcd_width_px, panel.lcd_height_px));
    } catch (const ArgumentError& e) {
      throw FileError(dataset.file("alignments.json"), e.what(), "");
    }
  }
  dataset.write_eyes(eyes);
  return eyes;
}

std::vector<LightFieldView> load_light_field(const Dataset& dataset) {
  std::vector<LightFieldView> views;
  for (const ImportedView& v : read_poses_json(dataset.file("views.json"))) {
    if (v.path.empty())
      throw FileError(dataset.file("views.json"), "names a picture for " + v.name + " that is gone",
                      "run the step that writes it again");
    LightFieldView view{v.name, read_exr(v.path), v.intrinsics, v.T_camera_world};
    if (view.light_cd_m2.width() != v.intrinsics.width_px ||
        view.light_cd_m2.height() != v.intrinsics.height_px)
      throw FileError(v.path,
                      "is " + std::to_string(view.light_cd_m2.width()) + "x" +
                          std::to_string(view.light_cd_m2.height()) + ", views.json says " +
                          std::to_string(v.intrinsics.width_px) + "x" +
                          std::to_string(v.intrinsics.height_px),
                      "import or calibrate the poses again");
    views.push_back(std::move(view));
  }
  if (views.empty())
    throw FileError(dataset.file("views.json"), "holds no view", "import or capture some");
  return views;
}

void store_light_field(const Dataset& dataset, const std::vector<LightFieldView>& views) {
  make_folder(dataset.file("views"));
  std::vector<ImportedView> posed;
  for (const LightFieldView& v : views) {
    const std::filesystem::path file = dataset.file("views/" + v.name + ".exr");
    write_exr(file, v.light_cd_m2, ExrPrecision::kHalf);
    posed.push_back({v.name, file, v.intrinsics, {}, v.T_camera_world});
  }
  write_poses_json(dataset.file("views.json"), posed);
}

}  // namespace wheatstone::apps
