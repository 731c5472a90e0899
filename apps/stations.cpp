#include "apps/stations.h"

#include <algorithm>
#include <cstdio>

#include "apps/plot.h"
#include "calib/eye_solver.h"
#include "calib/marker_matching.h"
#include "calib/markers.h"
#include "capture/import/poses_json.h"
#include "capture/rectify.h"
#include "core/error.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/json.h"
#include "core/png.h"

namespace wheatstone::apps {

using nlohmann::json;

namespace {

constexpr double kNearPlaneMm = 360;
// A view whose markers fit 5 times worse than the median's, and worse than half a pixel, does not
// belong to the others' rail.
constexpr double kMisfitOfMedian = 5, kMisfitPx = 0.5;
constexpr double kMisplacedMm = 1;  // between the markers and the rail's encoder

json bad_views_json(const std::vector<BadView>& bad) {
  json list = json::array();
  for (const BadView& b : bad) list.push_back({{"name", b.name}, {"reason", b.reason}});
  return list;
}

/// The markers in every view's frame; views that do not show them as they stand go to `bad`.
std::vector<std::vector<MarkerSighting>> sightings(const Dataset& dataset,
                                                   const CameraProfile& camera,
                                                   const std::vector<Eigen::Vector3d>& markers,
                                                   std::vector<CapturedView>& frames,
                                                   std::vector<BadView>& bad) {
  std::vector<std::vector<MarkerSighting>> seen;
  std::vector<CapturedView> good;
  for (const CapturedView& view : frames) {
    const std::string file = dataset.file(view.marker_frame.file).string();
    const MosaicImage frame = read_mosaic_png(file, camera.pattern);
    try {
      std::vector<MarkerSighting> marks;
      for (const MarkerBlob& b : match_markers(find_markers(frame, camera), markers,
                                               camera.intrinsics, camera.distortion, file))
        marks.push_back({b.centroid_px, b.covariance_px2});
      seen.push_back(marks);
      good.push_back(view);
    } catch (const ArgumentError& e) {
      bad.push_back({view.name, e.what()});
    }
  }
  frames = good;
  return seen;
}

/// A view that the others contradict, by its index.
struct OddView {
  std::size_t view = 0;
  std::string reason;
};

std::vector<OddView> misfits(const PoseSolution& solution) {
  std::vector<double> sorted = solution.view_rms_px;
  std::sort(sorted.begin(), sorted.end());
  const double limit = std::max(kMisfitPx, kMisfitOfMedian * sorted[sorted.size() / 2]);
  std::vector<OddView> found;
  for (std::size_t v = 0; v < sorted.size(); ++v) {
    if (!(solution.view_rms_px[v] > limit)) continue;
    char reason[160];
    std::snprintf(reason, sizeof reason,
                  "its markers fit the other views' rail to %.2f px only (median %.2f px)",
                  solution.view_rms_px[v], solution.rms_free_px);
    found.push_back({v, reason});
  }
  return found;
}

std::vector<OddView> misplaced(const PoseSolution& solution,
                               const std::vector<CapturedView>& frames) {
  std::vector<Eigen::Vector3d> centres;
  std::vector<double> positions_mm;
  for (std::size_t v = 0; v < frames.size(); ++v) {
    centres.push_back(camera_centre(solution.T_camera_rsb[v]));
    positions_mm.push_back(frames[v].reached_mm);
  }
  std::vector<OddView> found;
  for (const MisplacedView& m : misplaced_views(centres, positions_mm, kMisplacedMm)) {
    char reason[160];
    std::snprintf(reason, sizeof reason,
                  "its markers put it at %.2f mm on the rail, which reported %.2f mm", m.seen_mm,
                  m.reported_mm);
    found.push_back({m.view, reason});
  }
  return found;
}

void require_no_bad_views(const std::vector<BadView>& bad, std::size_t good) {
  if (bad.empty()) return;
  std::string names;
  for (const BadView& b : bad) names += (names.empty() ? "" : ", ") + b.name;
  throw ArgumentError(
      "bad view " + names + ": " + bad.front().reason,
      good == 0 ? "no view is left" : "or leave such views out with --skip-bad-views");
}

/// How far the carriage strays from a straight rail with even steps, over its own positions.
void write_rail_plot(const std::filesystem::path& file, const RailReport& rail,
                     const std::vector<double>& positions_mm) {
  const PlotAxis position = {"position on the rail (mm)"};
  Plot across("Straightness", position, {"distance from the best line (mm)"});
  const char* const names[] = {"right", "up", "towards viewer"};
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> off;
    for (const Eigen::Vector3d& p : rail.off_line_mm) off.push_back(p[axis]);
    across.points(names[axis], positions_mm, off);
  }
  Plot along("Steps", position, {"travel beyond what was asked (mm)"});
  along.points("step error", positions_mm, rail.step_error_mm);
  along.hide_legend();
  write_svg(file, {across, along}, 2);
}

void write_pose_report(const Dataset& dataset, const CameraProfile& camera,
                       const std::vector<CapturedView>& frames, const PoseSolution& s,
                       const std::vector<BadView>& bad, const CommonBox& box,
                       std::optional<RailReport>& rail) {
  json views = json::array();
  std::vector<double> positions_mm;
  for (std::size_t v = 0; v < frames.size(); ++v) {
    positions_mm.push_back(frames[v].reached_mm);
    json residuals = json::array();
    for (const Eigen::Vector2d& r : s.residuals_px[v]) residuals.push_back({r.x(), r.y()});
    views.push_back(
        {{"name", frames[v].name},
         {"centre_rsb_mm", to_json(camera_centre(s.T_camera_rsb[v]))},
         {"covariance_rad_mm", to_json(Eigen::MatrixXd(s.covariance[v]))},
         {"rms_px", s.view_rms_px[v]},
         {"residuals_px", residuals},
         {"near_plane_sigma_px",
          plane_uncertainty_px(s.T_camera_rsb[v], s.covariance[v], camera.intrinsics,
                               camera.distortion, kNearPlaneMm, box.min_mm, box.max_mm)}});
  }
  json document = {{"views", views},
                   {"rms_px", s.rms_px},
                   {"rms_free_px", s.rms_free_px},
                   {"scatter_px", s.scatter_px},
                   {"scatter_free_px", s.scatter_free_px},
                   {"noise_factor", s.noise_factor},
                   {"bad_views", bad_views_json(bad)},
                   {"rail", nullptr}};
  const auto [least, most] = std::minmax_element(positions_mm.begin(), positions_mm.end());
  if (*most > *least) {
    rail = report_rail(s.free_centres_rsb, positions_mm);
    document["rail"] = {{"direction_rsb", to_json(rail->direction_rsb)},
                        {"straightness_rms_mm", rail->straightness_rms_mm},
                        {"straightness_largest_mm", rail->straightness_largest_mm},
                        {"pitch_mm", rail->pitch_mm},
                        {"scale", rail->scale},
                        {"step_error_rms_mm", rail->step_error_rms_mm},
                        {"step_error_largest_mm", rail->step_error_largest_mm}};
    for (std::size_t v = 0; v < frames.size(); ++v) {
      document["views"][v]["off_line_mm"] = to_json(rail->off_line_mm[v]);
      document["views"][v]["step_error_mm"] = rail->step_error_mm[v];
    }
    write_rail_plot(dataset.file("rail.svg"), *rail, positions_mm);
  }
  write_json(dataset.file("pose_report.json"), "wheatstone-pose-report/1", document);
}

}  // namespace

PoseCalibration calibrate_poses(const Dataset& dataset, const Progress& progress,
                                const PoseCalibrationOptions& options) {
  const CameraProfile camera = dataset.read_camera();
  PoseCalibration out;
  out.frames = dataset.read_frames();
  const std::vector<Eigen::Vector3d> markers = dataset.read_landmarks().markers_mm;
  auto seen = sightings(dataset, camera, markers, out.frames, out.bad_views);
  if (!options.skip_bad_views || seen.empty()) require_no_bad_views(out.bad_views, seen.size());
  const auto solve = [&] {
    out.solution = solve_poses(markers, seen, camera.intrinsics, camera.distortion, options.solver);
  };
  const auto solve_without = [&](const std::vector<OddView>& odd) {
    if (odd.empty()) return;
    for (const OddView& o : odd) out.bad_views.push_back({out.frames[o.view].name, o.reason});
    for (auto o = odd.rbegin(); o != odd.rend(); ++o) {
      out.frames.erase(out.frames.begin() + static_cast<std::ptrdiff_t>(o->view));
      seen.erase(seen.begin() + static_cast<std::ptrdiff_t>(o->view));
    }
    if (!options.skip_bad_views || seen.empty()) require_no_bad_views(out.bad_views, seen.size());
    solve();
  };
  solve();
  solve_without(misfits(out.solution));
  solve_without(misplaced(out.solution, out.frames));
  const std::vector<CapturedView>& frames = out.frames;
  const PoseSolution& solution = out.solution;

  for (const CapturedView& view : frames)
    if (const auto file = dataset.file("hdr/" + view.name + ".exr"); !std::filesystem::exists(file))
      throw FileError(file, "is missing", "run `wheatstone merge` on this folder first");

  std::vector<ImportedView> posed;
  for (std::size_t i = 0; i < frames.size(); ++i)
    posed.push_back({frames[i].name, dataset.file("hdr/" + frames[i].name + ".exr"),
                     camera.intrinsics, camera.distortion, solution.T_camera_rsb[i]});
  write_poses_json(dataset.file("poses.json"), posed);

  const CommonBox box;
  write_pose_report(dataset, camera, frames, solution, out.bad_views, box, out.rail);
  const cv::Size size = common_size(camera.intrinsics, solution.T_camera_rsb, box);
  make_folder(dataset.file("views"));
  std::vector<ImportedView> cropped;
  for (std::size_t i = 0; i < posed.size(); ++i) {
    const RgbImage photo = read_exr(posed[i].path);
    const LightFieldView view =
        options.crop_per_view
            ? rectify_to_own_box(posed[i].name, photo, camera.intrinsics, camera.distortion,
                                 posed[i].T_camera_world, box)
            : rectify_to_common_box(posed[i].name, photo, camera.intrinsics, camera.distortion,
                                    posed[i].T_camera_world, box, size);
    out.photographed_px += static_cast<std::int64_t>(photo.pixels.total());
    out.common_px += std::int64_t{size.width} * size.height;
    out.cropped_px += static_cast<std::int64_t>(view.light_cd_m2.pixels.total());
    const std::filesystem::path file = dataset.file("views/" + view.name + ".exr");
    write_exr(file, view.light_cd_m2, ExrPrecision::kHalf);
    cropped.push_back({view.name, file, view.intrinsics, {}, view.T_camera_world});
    progress("crop", static_cast<int>(i) + 1, static_cast<int>(posed.size()));
  }
  write_poses_json(dataset.file("views.json"), cropped);
  return out;
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
