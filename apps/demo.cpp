#include "apps/demo.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>

#include "apps/check.h"
#include "apps/import.h"
#include "apps/report.h"
#include "capture/alignment.h"
#include "capture/session.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/json.h"
#include "core/png.h"
#include "rendering/metrics/false_colour.h"
#include "rendering/metrics/pu21.h"

namespace wheatstone::apps {

namespace {

using nlohmann::json;

constexpr double kPictureWhiteCdM2 = 450;

json figure(double value, const std::string& unit) {
  return {{"value", value}, {"unit", unit}};
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string explain(const std::string& scene) {
  if (scene == "card")
    return "A flat card at the far plane: the focal plane of the light field can lie on all of it.";
  if (scene == "sphere")
    return "A light field without geometry has one focal plane. The sphere curves away from it and "
           "the wall lies far behind: both are ghosted, the more the farther they are from the "
           "plane. This is the method's expected failure, not a fault of the displays.";
  return "Objects at three depths and one focal plane: what does not lie on the plane is seen "
         "doubled, most of all at the occluding edge in front. This is the method's expected "
         "failure; a lumigraph or multi-plane image would need the depth that it lacks.";
}

// Everything of one scene on the simulated rig; adds to report and summary. Returns its row of the
// overview.
std::vector<std::string> demo_scene(const std::string& scene, const DemoOptions& options,
                                    Report& report, json& summary, const Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  const Dataset dataset(options.out / scene);
  std::filesystem::remove_all(dataset.root());
  make_folder(dataset.root());
  SimulatedRig twin({scene, options.scale, options.seed});
  twin.world().faults.arm_at_random(options.fault_probability, options.seed);
  const Rig rig = twin.rig();
  capture_light_field(
      rig, dataset, {"capture", scene, options.seed, options.scale, "simulated rig", 0, 1}, {},
      {{}, [&](int done, int total) { progress(scene + ": capture", done, total); }, {}});
  const auto step = [&](const std::string& what, int done, int total) {
    progress(scene + ": " + what, done, total);
  };
  merge(dataset, step);
  const PoseSolution poses = calibrate_poses(dataset, step).solution;
  record_alignments(rig, dataset);
  const std::vector<EyeDisplayCalibration> eyes = calibrate_eyes(dataset);
  const TargetReport target = render_drlf(dataset, std::nullopt, true, step);
  const PresentReport drive = split_to_drive_frames(dataset);
  const std::array<EyeCheck, 2> checks = check_at_eye(dataset, twin);

  const std::vector<CapturedView> frames = dataset.read_frames();
  double centre_error2 = 0;
  double predicted2 = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Eigen::Vector3d truth = camera_centre(true_T_camera_rsb(frames[i].reached_mm));
    centre_error2 += (camera_centre(poses.T_camera_rsb[i]) - truth).squaredNorm();
    predicted2 += poses.centre_covariance_mm2(i).trace();
  }
  const double centre_rms_mm = std::sqrt(centre_error2 / frames.size());
  const double predicted_rms_mm = std::sqrt(predicted2 / frames.size());
  double eye_rms_px = 0;
  for (const EyeDisplayCalibration& e : eyes) eye_rms_px = std::max(eye_rms_px, e.rms_px);

  json& figures = summary["scenes"][scene];
  figures["led_reprojection_rms"] = figure(poses.rms_px, "px");
  figures["camera_centre_error_rms"] = figure(centre_rms_mm, "mm");
  figures["camera_centre_predicted_sigma_rms"] = figure(predicted_rms_mm, "mm");
  figures["eye_alignment_rms_worst"] = figure(eye_rms_px, "px");
  figures["focal_distance"] = figure(target.focal_distance_mm, "mm");
  figures["near_weight"] = figure(target.near_weight, "1");
  figures["smallest_coverage"] = figure(target.smallest_coverage, "1");
  figures["pixels_above_peak"] = figure(drive.above_peak_px, "px");
  figures["pixels_below_black"] = figure(drive.below_black_px, "px");
  figures["pu21_psnr_left"] = figure(checks[0].pu21_psnr_db, "dB");
  figures["pu21_psnr_right"] = figure(checks[1].pu21_psnr_db, "dB");
  figures["pu21_ssim_left"] = figure(checks[0].pu21_ssim, "1");
  figures["pu21_ssim_right"] = figure(checks[1].pu21_ssim, "1");
  figures["hdr_vdp3_left"] = figure(checks[0].hdrvdp3_jod, "JOD");
  figures["hdr_vdp3_right"] = figure(checks[1].hdrvdp3_jod, "JOD");
  figures["duration"] = figure(seconds_since(start), "s");

  report.heading("Scene: " + scene);
  report.paragraph(explain(scene));
  report.facts({{"PU21-PSNR at the left / right eye",
                 fmt::format("{:.2f} / {:.2f} dB", checks[0].pu21_psnr_db, checks[1].pu21_psnr_db)},
                {"PU21-SSIM at the left / right eye",
                 fmt::format("{:.4f} / {:.4f}", checks[0].pu21_ssim, checks[1].pu21_ssim)},
                {"HDR-VDP-3 at the left / right eye (10: no difference)",
                 fmt::format("{:.2f} / {:.2f} JOD", checks[0].hdrvdp3_jod, checks[1].hdrvdp3_jod)},
                {"marker LED reprojection, RMS", fmt::format("{:.4f} px", poses.rms_px)},
                {"camera centres against the twin's truth, RMS",
                 fmt::format("{:.4f} mm (predicted {:.4f} mm)", centre_rms_mm, predicted_rms_mm)},
                {"eye alignment, worst display, RMS", fmt::format("{:.3f} px", eye_rms_px)},
                {"focal plane, from the eye", fmt::format("{:.1f} mm", target.focal_distance_mm)},
                {"light on the near plane", fmt::format("{:.1f} %", 100 * target.near_weight)},
                {"pixels the displays cannot show (too bright / too dark)",
                 fmt::format("{} / {}", drive.above_peak_px, drive.below_black_px)}});
  for (const EyeCheck* check : {&checks[0], &checks[1]}) {
    const std::string eye = check == &checks[0] ? "Left eye" : "Right eye";
    report.pictures(
        {{to_srgb8(check->displays, kPictureWhiteCdM2),
          eye + ": the driven displays (white = 450 cd/m²)"},
         {to_srgb8(check->box, kPictureWhiteCdM2), eye + ": the real box"},
         {false_colour_difference(check->difference_pu, 50, "PU21 units"), eye + ": difference"}});
  }
  std::vector<Eigen::Vector2d> led_residuals;
  for (const auto& view : poses.residuals_px)
    led_residuals.insert(led_residuals.end(), view.begin(), view.end());
  report.residual_plot(led_residuals, "Marker LEDs, all views: predicted minus seen");
  std::vector<Eigen::Vector2d> eye_residuals;
  for (const EyeDisplayCalibration& e : eyes)
    eye_residuals.insert(eye_residuals.end(), e.residuals_px.begin(), e.residuals_px.end());
  report.residual_plot(eye_residuals, "Eye alignment, all displays: predicted minus aligned");
  const auto both = [&](double EyeCheck::*value) {
    return fmt::format("{:.2f} / {:.2f}", checks[0].*value, checks[1].*value);
  };
  return {scene, both(&EyeCheck::pu21_psnr_db), both(&EyeCheck::hdrvdp3_jod),
          fmt::format("{:.4f}", centre_rms_mm), fmt::format("{:.3f}", eye_rms_px)};
}

void demo_stereo(const std::filesystem::path& data, const DemoOptions& options, Report& report,
                 json& summary) {
  const Dataset dataset(options.out / "real_stereo");
  std::filesystem::remove_all(dataset.root());
  const std::string line = import_input(data / "openexr_stereo/beachball/singlepart.0001.exr",
                                        dataset, {"auto", 300, 0, 13.2});
  SimulatedRig twin({"card", options.scale, options.seed});
  twin.world().faults.arm_at_random(options.fault_probability, options.seed);
  const Rig rig = twin.rig();
  record_alignments(rig, dataset);
  calibrate_eyes(dataset);
  render_rgbd(dataset);
  split_to_drive_frames(dataset);
  present(dataset, rig);

  report.heading("Real input: a stereo frame with depth");
  report.paragraph("openexr_stereo/beachball: " + line +
                   ". Each eye's light is split over the two planes by its depth, per pixel; what "
                   "the simulated eye receives is compared with the frame itself, seen through the "
                   "same window. Pure colours differ most: a dark channel cannot fall below a "
                   "thousandth of the backlight that its bright neighbour needs.");
  json& figures = summary["real_stereo"];
  for (const LightFieldView& view : load_light_field(dataset)) {
    const Eye eye = view.name == "left" ? Eye::kLeft : Eye::kRight;
    const PanelModel& far = rig.panel_models[index_of({eye, Plane::kFar})];
    const EyeCamera camera{far.lcd_width_px, far.lcd_height_px, 3};
    const RgbImage seen = twin.eye().photograph_displays(eye, camera);
    const Intrinsics k = EyePhotograph::intrinsics(eye, camera);
    const RgbImage wanted = resample_pinhole(view, k);
    const double psnr = pu21_psnr_rgb(seen, wanted);
    figures["pu21_psnr_" + view.name] = figure(psnr, "dB");
    const std::string name = eye == Eye::kLeft ? "Left" : "Right";
    report.pictures(
        {{to_srgb8(seen, 300), fmt::format("{} eye: the driven displays, {:.2f} dB", name, psnr)},
         {to_srgb8(wanted, 300), name + " eye: the imported frame"},
         {false_colour_difference(pu21_difference(seen, wanted), 50, "PU21 units"),
          name + " eye: difference"}});
  }
}

void demo_left_out(const std::string& name, const std::filesystem::path& input,
                   const std::string& view, const DemoOptions& options, Report& report,
                   json& summary) {
  const Dataset dataset(options.out / name);
  std::filesystem::remove_all(dataset.root());
  const std::string line = import_input(input, dataset, {});
  const LeftOutReport r = render_left_out(dataset, view, std::nullopt, true);
  json& figures = summary[name];
  figures["left_out_view"] = view;
  figures["psnr_drlf"] = figure(r.psnr_drlf_db, "dB");
  figures["psnr_nearest"] = figure(r.psnr_nearest_db, "dB");
  figures["psnr_average_of_two"] = figure(r.psnr_average_db, "dB");
  figures["focal_distance"] = figure(r.focal_distance_mm, "mm");
  report.heading("Real input: " + name);
  report.paragraph(line + fmt::format(". View {} was left out and rendered from the others, focal "
                                      "plane at {:.0f} mm, found by the agreement of the views.",
                                      view, r.focal_distance_mm));
  report.table({"answer", "PSNR of 8-bit sRGB (dB)"},
               {{"DRLF", fmt::format("{:.2f}", r.psnr_drlf_db)},
                {"nearest view (" + r.nearest + ")", fmt::format("{:.2f}", r.psnr_nearest_db)},
                {"plain average with " + r.second, fmt::format("{:.2f}", r.psnr_average_db)}});
  report.pictures(
      {{to_srgb8(r.rendered, 100), "Rendered"},
       {to_srgb8(r.reference, 100), "The photograph that was left out"},
       {false_colour_difference(pu21_difference(r.rendered, r.reference), 50, "PU21 units"),
        "Difference"}});
}

}  // namespace

void run_demo(const DemoOptions& options, const Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  make_folder(options.out);
  Report report("Wheatstone: from a captured light field to the observer's eyes");
  report.paragraph(fmt::format(
      "Simulated rig, seed {}, scale {} of the full pixel counts. For each scene the camera "
      "captures a light field of the box, the rig is calibrated, both eyes' views are rendered "
      "for all four displays and split into eight drive frames. The simulated eye then "
      "photographs the driven displays and, from the same place, the real box.",
      options.seed, options.scale));
  json summary;
  summary["seed"] = options.seed;
  summary["scale"] = options.scale;
  Report details("");
  std::vector<std::vector<std::string>> overview;
  for (const std::string& scene : options.scenes)
    overview.push_back(demo_scene(scene, options, details, summary, progress));
  report.heading("How near the displays come to the box");
  report.table({"scene", "PU21-PSNR left / right (dB)", "HDR-VDP-3 left / right (JOD)",
                "camera centres off by (mm)", "eyes off by (px)"},
               overview);
  report.paragraph(
      "10 JOD is no visible difference. The last two columns are root mean squares: of the "
      "calibrated camera against the twin's truth, and of the worst display's alignment.");
  if (options.real_data) {
    progress("real input", 0, 2);
    demo_stereo(*options.real_data, options, details, summary);
    progress("real input", 1, 2);
    demo_left_out("lightfield_shop", *options.real_data / "lightfield_shop",
                  "shop_13_13_-0.000000_0.000000_30_36", options, details, summary);
    progress("real input", 2, 2);
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  summary["duration"] = figure(seconds_since(start), "s");
  summary["peak_memory"] = figure(usage.ru_maxrss / 1048576.0, "GiB");
  report.append(details);
  report.write(options.out / "report.html");
  write_json(options.out / "summary.json", "wheatstone-summary/1", summary);
}

}  // namespace wheatstone::apps
