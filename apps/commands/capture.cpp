#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>

#include "apps/commands/commands.h"
#include "apps/commands/common.h"
#include "apps/drivers.h"
#include "apps/rig_source.h"
#include "apps/stop_on_signal.h"
#include "capture/exposure_planning.h"
#include "capture/session.h"
#include "core/error.h"
#include "core/files.h"
#include "core/text.h"
#include "hardware/watchdog.h"

namespace wheatstone::apps {
namespace {

using nlohmann::json;

struct CaptureOptions {
  std::string folder;
  SimulationOptions simulation;
  std::string rig, transcript;
  ChaosOption chaos;
  CapturePlan plan;
  double coverage = 0.95;
  std::vector<std::string> exposures = {"1/240", "1/60", "1/15"};
  bool dry_run = false, as_json = false;
};

/// Seconds, as 0.0167 or as the camera shows them, 1/60.
double exposure_from_string(const std::string& text) {
  const std::size_t slash = text.find('/');
  const auto number = [&](const std::string& part) {
    std::size_t used = 0;
    double value = 0;
    try {
      value = std::stod(part, &used);
    } catch (const std::exception&) {  // used stays 0
    }
    if (used == 0 || used != part.size() || !(value > 0) || !std::isfinite(value))
      throw ArgumentError("'" + text + "' is no exposure time",
                          "give seconds above 0, as 0.0167 or 1/60");
    return value;
  };
  if (slash == std::string::npos) return number(text);
  return number(text.substr(0, slash)) / number(text.substr(slash + 1));
}

/// Tells a person or a program what happens.
class Teller {
 public:
  explicit Teller(bool as_json) : as_json_(as_json) {}

  void plan(const CapturePlan& plan, const CaptureForecast& forecast, int total) const {
    if (as_json_) {
      tell({{"event", "forecast"},
            {"plan", to_json(plan)},
            {"frames", forecast.frames},
            {"frames_of_session", total},
            {"duration_s", forecast.duration_s},
            {"bytes", forecast.bytes}});
      return;
    }
    fmt::print(
        "{}, exposures {:.4g} s: {} of {} to take, {:.0f} s on the rig, up to "
        "{:.1f} MB\n",
        counted(plan.views, "view"), fmt::join(plan.exposures_s, ", "), forecast.frames,
        counted(total, "frame"), forecast.duration_s, static_cast<double>(forecast.bytes) / 1e6);
    std::fflush(stdout);  // before what follows, in a log too
  }

  void record(const json& r) {
    if (as_json_) return tell(r);
    const std::string event = r.at("event");
    if (event == "set aside")
      fmt::print("{} {}: taken again\n", r.at("file").get<std::string>(),
                 r.at("why").get<std::string>());
    if (event == "markers")
      fmt::print(stderr,
                 "warning: {}\nwithout its markers no view gets a pose: stop the capture and put "
                 "that right, unless the light alone is wanted\n",
                 r.at("problem").get<std::string>());
    if (event == "returned") returned(r);
  }

  void progress(int done, int total) {
    if (done == last_done_) return;  // a view that was there already
    last_done_ = done;
    if (first_done_ < 0) first_done_ = done;
    const double elapsed_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const double rate = (done - first_done_) / std::max(elapsed_s, 1e-9);
    const double left_s = rate > 0 ? (total - done) / rate : 0;
    if (as_json_)
      tell({{"event", "progress"},
            {"done", done},
            {"total", total},
            {"frames_per_s", rate},
            {"seconds_left", left_s}});
    else
      show_progress(done == total || rate == 0
                        ? "capture"
                        : fmt::format("capture, {:.2g} frames/s, {:.0f} s left", rate, left_s),
                    done, total);
  }

 private:
  static void tell(const json& event) {
    fmt::print("{}\n", event.dump());
    std::fflush(stdout);
  }

  /// Backlash or lost steps move the camera where the encoder sees nothing.
  static void returned(const json& r) {
    constexpr double kWarnMm = 0.1;
    const double encoder_mm = r.at("encoder_mm");
    if (r.contains("problem")) {
      fmt::print(stderr, "the return to the start could not be checked: {}\n",
                 r.at("problem").get<std::string>());
      return;
    }
    const double seen_mm = r.at("seen_mm");
    fmt::print("back at the start: {:+.3f} mm by the encoder, {:+.3f} mm as the markers show\n",
               encoder_mm, seen_mm);
    if (std::abs(seen_mm - encoder_mm) > kWarnMm)
      fmt::print(stderr,
                 "warning: backlash or lost steps of {:.2f} mm; the poses come from the markers, "
                 "the rail's positions are not to be trusted\n",
                 std::abs(seen_mm - encoder_mm));
  }

  const bool as_json_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  int first_done_ = -1, last_done_ = -1;
};

/// The exposures of the session in the folder, so that a resumed one does not probe again (one
/// planned otherwise is refused later); else planned from a probe.
std::vector<double> exposures_for(const CapturePlan& plan, const Dataset& dataset, const Rig& rig,
                                  const std::stop_token& stop) {
  if (const std::optional<CapturePlan> there = recorded_plan(dataset)) return there->exposures_s;
  const LightRange light = probe_light(rig, plan, plan.coverage, stop);
  return plan_exposures(light, rig.camera_profile, plan.signal_to_noise);
}

RigSource source_of(const CaptureOptions& options) {
  const SimulationOptions& s = options.simulation;
  if (options.rig.empty()) return RigSource(SimulatedRigOptions{s.scene, s.scale, s.seed});
  return RigSource(read_rig_file(options.rig, all_drivers()), options.transcript);
}

void run_capture(const CaptureOptions& options) {
  const StopOnSignal stop;
  RigSource source = source_of(options);
  const Rig rig = source.rig();
  const Dataset dataset(options.folder);
  options.chaos.arm(source.twin());
  Watchdog watchdog(source.watchdog(), [&rig] {
    std::fputs("wheatstone: the capture hangs; the rig is made safe\n", stderr);
    make_safe(rig);
  });
  CapturePlan plan = options.plan;
  if (plan.signal_to_noise == 0) {
    plan.exposures_s.clear();
    for (const std::string& text : options.exposures)
      plan.exposures_s.push_back(exposure_from_string(text));
  }
  require_possible(plan, rig);
  if (plan.signal_to_noise != 0) {
    plan.coverage = options.coverage;
    plan.exposures_s = exposures_for(plan, dataset, rig, stop.token());
  }
  Teller teller(options.as_json);
  const SimulatedRigOptions& twin = source.simulation();
  const DatasetManifest manifest{"capture", twin.scene, twin.seed, twin.scale, source.name(), 0, 1};
  teller.plan(plan, forecast(missing_shots(rig, dataset, manifest, plan), plan, rig),
              static_cast<int>(shots_of(plan, rig.stage->travel()).size()));
  if (options.dry_run) return;
  make_folder(dataset.root());
  capture_light_field(rig, dataset, manifest, plan,
                      {[&](const json& r) {
                         watchdog.pet();
                         teller.record(r);
                       },
                       [&](int done, int total) { teller.progress(done, total); }, stop.token()});
}

}  // namespace

void add_capture(CLI::App& app) {
  auto* command = app.add_subcommand(
      "capture", "Capture a light field of the box; goes on where an earlier run was ended");
  auto options = std::make_shared<CaptureOptions>();
  CapturePlan& plan = options->plan;
  command->add_option("dataset", options->folder, "dataset folder, new or of the same session")
      ->required();
  options->simulation.add_to(*command);
  auto* rig = command->add_option("--rig", options->rig, "rig file; without it, the twin");
  for (const char* of_the_twin : {"--scene", "--scale", "--seed"})
    command->get_option(of_the_twin)->excludes(rig);
  command
      ->add_option("--transcript", options->transcript,
                   "writes what goes over the wires to this file")
      ->needs(rig);
  options->chaos.add_to(*command);
  command->add_option("--views", plan.views, "rail positions")->capture_default_str();
  auto* exposures =
      command
          ->add_option("--exposures", options->exposures, "exposure times in s, as 0.0167 or 1/60")
          ->capture_default_str();
  auto* ratio = command->add_option("--signal-to-noise", plan.signal_to_noise,
                                    "probe the box and take the fewest exposures that reach this "
                                    "ratio in all views");
  ratio->excludes(exposures)->check(CLI::PositiveNumber);
  command->add_option("--coverage", options->coverage, "share of the pixels that have to reach it")
      ->capture_default_str()
      ->needs(ratio);
  command->add_option("--marker-exposure", plan.marker_exposure_s, "of the marker frames, in s")
      ->capture_default_str();
  command->add_option("--settle", plan.settle_s, "rest after every move, in s")
      ->capture_default_str();
  command->add_flag("--dry-run", options->dry_run, "only say what would be taken, time and disk");
  command->add_flag("--json", options->as_json, "one JSON object per event on standard output");
  command->footer(
      "Example:\n"
      "  wheatstone capture out/card --scene card --scale 0.1\n"
      "  wheatstone capture out/planned --scene card --scale 0.1 --signal-to-noise 50 --dry-run");
  command->callback([options] { run_capture(*options); });
}

}  // namespace wheatstone::apps
