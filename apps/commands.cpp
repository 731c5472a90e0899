#include "apps/commands.h"

#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <memory>

#include "apps/check.h"
#include "apps/demo.h"
#include "apps/import.h"
#include "apps/stations.h"
#include "capture/session.h"
#include "core/error.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/png.h"
#include "rendering/gl/offscreen.h"

namespace wheatstone::apps {

namespace {

void show_progress(const std::string& what, int done, int total) {
  if (isatty(STDERR_FILENO)) {
    fmt::print(stderr, "\r{}: {}/{}\x1b[K{}", what, done, total, done == total ? "\n" : "");
  } else if (done == total) {
    fmt::print(stderr, "{}: done\n", what);
  }
}

struct SimulationOptions {
  std::string scene = "card";
  double scale = 0.25;
  std::uint64_t seed = 7;

  void add_to(CLI::App& command) {
    command.add_option("--scene", scene, "card, sphere or objects")->capture_default_str();
    command.add_option("--scale", scale, "of all pixel counts of the simulated rig, in (0, 1]")
        ->capture_default_str();
    command.add_option("--seed", seed, "of everything random")->capture_default_str();
  }
};

/// The dataset in a folder that must be one, of a version this program reads.
Dataset open_dataset(const std::string& folder) {
  const Dataset dataset(folder);
  if (!std::filesystem::exists(dataset.file("dataset.json")))
    throw FileError(dataset.file("dataset.json"), "is missing",
                    "name a folder that `wheatstone capture` or `wheatstone import` has finished");
  dataset.read_manifest();
  return dataset;
}

/// The twin that a captured folder came from; imported folders are shown on the default twin.
SimulatedRigOptions twin_of(const Dataset& dataset, double scale) {
  const DatasetManifest m = dataset.read_manifest();
  if (m.kind == "capture") return {m.scene, m.scale, m.seed};
  return {"card", scale, 7};
}

void add_demo(CLI::App& app) {
  auto* command = app.add_subcommand("demo", "The whole way on the simulated rig, with a report");
  auto options = std::make_shared<DemoOptions>();
  auto real = std::make_shared<std::string>();
  command->add_option("--out", options->out, "folder for report.html and summary.json")
      ->capture_default_str();
  command->add_option("--real", *real, "folder with the real input sets");
  command->add_option("--scene", options->scenes, "scenes to run")->capture_default_str();
  command->add_option("--scale", options->scale, "of all pixel counts")->capture_default_str();
  command->add_option("--seed", options->seed, "of everything random")->capture_default_str();
  command->footer("Example:\n  wheatstone demo --out out/demo");
  command->callback([=] {
    if (!real->empty()) options->real_data = *real;
    run_demo(*options, show_progress);
    fmt::print("{}\n{}\n", (options->out / "report.html").string(),
               (options->out / "summary.json").string());
  });
}

void add_capture(CLI::App& app) {
  auto* command = app.add_subcommand("capture", "Capture a light field of the box");
  auto simulation = std::make_shared<SimulationOptions>();
  auto folder = std::make_shared<std::string>();
  auto plan = std::make_shared<CapturePlan>();
  command->add_option("dataset", *folder, "new dataset folder")->required();
  simulation->add_to(*command);
  command->add_option("--views", plan->views, "rail positions")->capture_default_str();
  command->add_option("--exposures", plan->exposures_s, "exposure times in s")
      ->capture_default_str();
  command->footer("Example:\n  wheatstone capture out/card --scene card --scale 0.1");
  command->callback([=] {
    const Dataset dataset(*folder);
    if (std::filesystem::exists(dataset.file("dataset.json")))
      throw FileError(dataset.root(), "holds a dataset already", "choose another folder");
    SimulatedRig twin({simulation->scene, simulation->scale, simulation->seed});
    make_folder(dataset.root());
    capture_light_field(twin.rig(), dataset, *plan,
                        [](int done, int total) { show_progress("capture", done, total); });
    dataset.write_manifest(
        {"capture", simulation->scene, simulation->seed, simulation->scale, "simulated rig", 0, 1});
  });
}

void add_merge(CLI::App& app) {
  auto* command = app.add_subcommand("merge", "Merge raw exposures to HDR views in cd/m2");
  auto folder = std::make_shared<std::string>();
  command->add_option("dataset", *folder, "dataset folder")->required();
  command->footer("Example:\n  wheatstone merge out/card");
  command->callback([=] { merge(open_dataset(*folder), show_progress); });
}

void add_calibrate(CLI::App& app) {
  auto* calibrate = app.add_subcommand("calibrate", "Camera poses, eyes");
  calibrate->require_subcommand(1);
  calibrate->footer("Example:\n  wheatstone calibrate poses out/card");
  auto folder = std::make_shared<std::string>();
  auto scale = std::make_shared<double>(0.25);

  auto* poses = calibrate->add_subcommand(
      "poses", "Camera poses from the marker LEDs; crops the views to the common box");
  poses->add_option("dataset", *folder, "dataset folder, merged")->required();
  poses->footer("Example:\n  wheatstone calibrate poses out/card");
  poses->callback(
      [=] { fmt::print("{}\n", calibrate_poses(open_dataset(*folder), show_progress).report); });

  auto* eyes = calibrate->add_subcommand(
      "eyes",
      "Eyes and displays from eight aligned marks per display (alignments.json, or asked "
      "of the simulated observer when there is none)");
  eyes->add_option("dataset", *folder, "dataset folder")->required();
  eyes->add_option("--scale", *scale, "of the simulated displays, for imported input")
      ->capture_default_str();
  eyes->footer("Example:\n  wheatstone calibrate eyes out/card");
  eyes->callback([=] {
    const Dataset dataset = open_dataset(*folder);
    if (!std::filesystem::exists(dataset.file("alignments.json"))) {
      SimulatedRig twin(twin_of(dataset, *scale));
      record_alignments(twin.rig(), dataset);
    }
    for (const EyeDisplayCalibration& e : calibrate_eyes(dataset)) {
      const Eigen::Vector3d c = camera_centre(e.T_eye_rsb);
      fmt::print("{}: RMS {:.3f} px, eye at ({:.2f}, {:.2f}, {:.2f}) mm in rsb\n", to_string(e.id),
                 e.rms_px, c.x(), c.y(), c.z());
    }
  });
}

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
                   "auto, exr-stereo, light-field-renderer, colmap or poses")
      ->capture_default_str();
  command->add_option("--white-cd-m2", options->white_cd_m2, "luminance of full white")
      ->capture_default_str();
  command
      ->add_option("--mm-per-unit", options->mm_per_unit,
                   "length of the input's unit; 0: chosen as documented")
      ->capture_default_str();
  command->add_option("--hfov-deg", options->hfov_deg, "stereo EXR: field of view of the width")
      ->capture_default_str();
  command->footer("Example:\n  wheatstone import ../shared/data/lightfield_shop --out out/shop");
  command->callback([=] { fmt::print("{}\n", import_input(*input, Dataset(*folder), *options)); });
}

void add_render(CLI::App& app) {
  auto* command = app.add_subcommand("render",
                                     "What the four displays shall show, or a left-out "
                                     "view of a light field");
  auto folder = std::make_shared<std::string>();
  auto method = std::make_shared<std::string>("drlf");
  auto left_out = std::make_shared<std::string>();
  auto out = std::make_shared<std::string>();
  auto focus = std::make_shared<double>(0);
  auto cpu = std::make_shared<bool>(false);
  command->add_option("dataset", *folder, "dataset folder")->required();
  command->add_option("--method", *method, "drlf, or rgbd for an imported stereo frame")
      ->check(CLI::IsMember({"drlf", "rgbd"}))
      ->capture_default_str();
  command->add_option("--leave-out", *left_out, "render this view from all others and compare");
  command->add_option("--out", *out, "EXR for the left-out view");
  command->add_option("--focus-mm", *focus,
                      "focal plane: z in rsb for displays, distance from the camera with "
                      "--leave-out; found from the views when not given");
  command->add_flag("--cpu", *cpu, "the shader's CPU twin instead of OpenGL");
  command->footer(
      "Example:\n  wheatstone render out/shop --method drlf --leave-out "
      "shop_13_13_-0.000000_0.000000_30_36 --out out/shop_13_13.exr");
  command->callback([=] {
    const Dataset dataset = open_dataset(*folder);
    const auto plane =
        command->count("--focus-mm") > 0 ? std::optional<double>(*focus) : std::nullopt;
    if (!left_out->empty()) {
      const LeftOutReport r = render_left_out(dataset, *left_out, plane, !*cpu);
      if (!out->empty()) write_exr(*out, r.rendered);
      fmt::print(
          "focal plane {:.1f} mm\nDRLF {:.2f} dB\nnearest view {:.2f} dB ({})\naverage of "
          "two {:.2f} dB (with {})\n",
          r.focal_distance_mm, r.psnr_drlf_db, r.psnr_nearest_db, r.nearest, r.psnr_average_db,
          r.second);
      return;
    }
    const TargetReport r = *method == "rgbd" ? render_rgbd(dataset)
                                             : render_drlf(dataset, plane, !*cpu, show_progress);
    if (*method == "drlf")
      fmt::print("focal plane {:.1f} mm from the eye, {:.1f} % of the light on the near plane\n",
                 r.focal_distance_mm, 100 * r.near_weight);
  });
}

void add_present(CLI::App& app) {
  auto* command = app.add_subcommand("present", "Split to eight drive frames and show them");
  auto folder = std::make_shared<std::string>();
  auto scale = std::make_shared<double>(0.25);
  command->add_option("dataset", *folder, "dataset folder, rendered")->required();
  command->add_option("--scale", *scale, "of the simulated displays, for imported input")
      ->capture_default_str();
  command->footer("Example:\n  wheatstone present out/card");
  command->callback([=] {
    const Dataset dataset = open_dataset(*folder);
    const PresentReport r = split_to_drive_frames(dataset);
    fmt::print("eight frames in {}; {} pixels too bright, {} too dark for the displays\n",
               dataset.file("drive").string(), r.above_peak_px, r.below_black_px);
    SimulatedRig twin(twin_of(dataset, *scale));
    if (dataset.read_manifest().kind == "capture") {
      const auto checks = check_at_eye(dataset, twin);
      fmt::print("PU21-PSNR at the eye: left {:.2f} dB, right {:.2f} dB\n", checks[0].pu21_psnr_db,
                 checks[1].pu21_psnr_db);
    } else {
      present(dataset, twin.rig());
    }
  });
}

void add_doctor(CLI::App& app) {
  auto* command = app.add_subcommand("doctor", "What works on this machine, and what to do if not");
  command->footer("Example:\n  wheatstone doctor");
  command->callback([] {
    const OffscreenContext context;
    fmt::print("OpenGL: {} on {}\n", context.version(), context.renderer());
    SimulatedRig twin({"card", 0.02, 1});
    const Rig rig = twin.rig();
    const Length reached = rig.stage.home(rig.clock.in(60.0_s));
    fmt::print("simulated rig: rail homed at {:.3f} mm, {} markers, camera {}\n", reached.value(),
               rig.markers.count(), rig.camera_profile.serial);
  });
}

}  // namespace

void add_commands(CLI::App& app) {
  add_demo(app);
  add_capture(app);
  add_merge(app);
  add_calibrate(app);
  add_import(app);
  add_render(app);
  add_present(app);
  add_doctor(app);
}

}  // namespace wheatstone::apps
