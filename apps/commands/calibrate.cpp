#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/commands.h"
#include "apps/commands/common.h"
#include "apps/stations.h"
#include "capture/alignment.h"
#include "core/error.h"

namespace wheatstone::apps {
namespace {

// Residuals this many times the centroids' noise come from how the mosaic samples the spots; that
// error is alike in all views and does not average out.
constexpr double kLargeNoiseFactor = 4;

}  // namespace

void add_calibrate(CLI::App& app) {
  auto* calibrate =
      app.add_subcommand("calibrate", "Cameras, their colours and poses, the LED ceiling, eyes");
  calibrate->require_subcommand(1);
  calibrate->footer("Example:\n  wheatstone calibrate poses out/card");
  auto folder = std::make_shared<std::string>();
  auto scale = std::make_shared<double>(0.25);

  add_calibrate_camera(*calibrate);
  add_calibrate_stereo(*calibrate);
  add_calibrate_colour(*calibrate);
  add_calibrate_leds(*calibrate);

  auto* poses = calibrate->add_subcommand(
      "poses", "Camera poses from the marker LEDs; crops the views to the common box");
  poses->add_option("dataset", *folder, "dataset folder, merged")->required();
  auto pose_options = std::make_shared<PoseCalibrationOptions>();
  auto no_rail = std::make_shared<bool>(false);
  poses->add_flag("--no-rail-prior", *no_rail,
                  "a rotation for each view and centres anywhere, instead of one rotation and "
                  "centres along a line");
  poses
      ->add_option("--rail-straightness-mm", pose_options->solver.rail_straightness_mm,
                   "how far the rail may bend, standard deviation")
      ->capture_default_str();
  poses->add_flag("--skip-bad-views", pose_options->skip_bad_views,
                  "leave out views whose markers contradict the others or the LEDs' places");
  auto crop = std::make_shared<std::string>("common");
  poses
      ->add_option("--crop", *crop,
                   "common: all views of one size; per-view: each as small as it can be")
      ->check(CLI::IsMember({"common", "per-view"}))
      ->capture_default_str();
  poses->footer("Example:\n  wheatstone calibrate poses out/card");
  poses->callback([=] {
    pose_options->solver.straight_rail = !*no_rail;
    pose_options->crop_per_view = *crop == "per-view";
    const PoseCalibration c = calibrate_poses(open_dataset(*folder), show_progress, *pose_options);
    fmt::print("{}\n", c.solution.report);
    if (c.solution.noise_factor > kLargeNoiseFactor)
      fmt::print(stderr,
                 "warning: the marker spots are too few pixels wide for these standard deviations "
                 "(noise factor {:.1f}); errors that all views share may be 2 to 3 times larger\n",
                 c.solution.noise_factor);
    for (const BadView& b : c.bad_views) fmt::print("left out {}: {}\n", b.name, b.reason);
    constexpr double kMbPerPx = 12e-6;  // three floats
    fmt::print("views cropped from {:.1f} to {:.1f} MB in memory, {:.0f} % of the photos",
               kMbPerPx * static_cast<double>(c.photographed_px),
               kMbPerPx * static_cast<double>(c.cropped_px),
               100.0 * static_cast<double>(c.cropped_px) / static_cast<double>(c.photographed_px));
    if (pose_options->crop_per_view)
      fmt::print("; one size for all would take {:.1f} MB",
                 kMbPerPx * static_cast<double>(c.common_px));
    fmt::print("\n");
    if (c.rail)
      fmt::print(
          "rail: straight to {:.4f} mm (RMS), step error {:.4f} mm (RMS), pitch {:.3f} mm, scale "
          "{:.5f}\n",
          c.rail->straightness_rms_mm, c.rail->step_error_rms_mm, c.rail->pitch_mm, c.rail->scale);
    fmt::print("wrote poses.json, pose_report.json, {}views.json and the pictures in views\n",
               c.rail ? "rail.svg, " : "");
  });

  auto* eyes = calibrate->add_subcommand(
      "eyes",
      "Eyes and displays from eight aligned marks per display (alignments.json, or asked "
      "of the simulated observer when there is none)");
  eyes->add_option("dataset", *folder, "dataset folder")->required();
  eyes->add_option("--scale", *scale, "of the simulated displays, for imported input")
      ->capture_default_str();
  auto chaos = std::make_shared<ChaosOption>();
  chaos->add_to(*eyes);
  eyes->footer("Example:\n  wheatstone calibrate eyes out/card");
  eyes->callback([=] {
    const Dataset dataset = open_dataset(*folder);
    if (!std::filesystem::exists(dataset.file("alignments.json"))) {
      SimulatedRig twin(twin_of(dataset, *scale));
      chaos->arm(&twin);
      record_alignments(twin.rig(), dataset);
    }
    for (const EyeDisplayCalibration& e : calibrate_eyes(dataset)) {
      const Eigen::Vector3d c = camera_centre(e.T_eye_rsb);
      fmt::print("{}: RMS {:.3f} px, eye at ({:.2f}, {:.2f}, {:.2f}) mm in rsb\n", to_string(e.id),
                 e.rms_px, c.x(), c.y(), c.z());
    }
    fmt::print("wrote eyes.json\n");
  });
}

}  // namespace wheatstone::apps
