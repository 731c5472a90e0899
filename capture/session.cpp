#include "capture/session.h"

#include <cmath>

#include "core/error.h"
#include "core/files.h"
#include "core/png.h"

namespace wheatstone {

namespace {

constexpr Duration kMoveLimit = Duration::of(60), kExposeLimit = Duration::of(60);

class LightsOffAtExit {
 public:
  explicit LightsOffAtExit(const Rig& rig) : rig_(rig) {}
  ~LightsOffAtExit() {
    try {
      all(rig_, false);
      rig_.leds.set_all(0);
    } catch (...) {  // a dead light is dark enough; the first error is the one to report
    }
  }
  LightsOffAtExit(const LightsOffAtExit&) = delete;
  LightsOffAtExit& operator=(const LightsOffAtExit&) = delete;
  static void all(const Rig& rig, bool on) {
    for (int i = 0; i < rig.markers.count(); ++i) rig.markers.set(i, on);
  }

 private:
  const Rig& rig_;
};

std::string numbered(const std::string& stem, int i) {
  const std::string n = std::to_string(i);
  return stem + std::string(n.size() < 3 ? 3 - n.size() : 0, '0') + n;
}

}  // namespace

std::string validate(const CapturePlan& plan) {
  if (plan.views < 1) return "a capture needs at least one view";
  if (plan.exposures_s.empty()) return "a capture needs at least one exposure";
  for (double t : plan.exposures_s)
    if (!(t > 0) || !std::isfinite(t)) return "exposure times must be above 0 s";
  if (!(plan.marker_exposure_s > 0) || !std::isfinite(plan.marker_exposure_s))
    return "the marker exposure must be above 0 s";
  return "";
}

void capture_light_field(const Rig& rig, const Dataset& dataset, const CapturePlan& plan,
                         const std::function<void(int, int)>& progress) {
  if (const std::string reason = validate(plan); !reason.empty())
    throw ArgumentError(reason, "change the plan");
  make_folder(dataset.file("raw"));
  dataset.write_camera(rig.camera_profile);
  dataset.write_landmarks({rig.marker_positions_rsb_mm, rig.near_cross_positions_rsb_mm});
  dataset.write_displays(rig.panel_models);

  const LightsOffAtExit guard(rig);
  rig.stage.home(rig.clock.in(kMoveLimit));
  const int total = plan.views * (static_cast<int>(plan.exposures_s.size()) + 1);
  int done = 0;
  const auto shoot = [&](const std::string& file, double exposure_s) {
    const RawFrame frame = rig.camera.expose(Duration::of(exposure_s), rig.clock.in(kExposeLimit));
    write_mosaic_png(dataset.file(file), frame.mosaic);
    progress(++done, total);
    return ExposureRecord{file, frame.exposure.value()};
  };

  std::vector<CapturedView> views;
  for (int i = 0; i < plan.views; ++i) {
    CapturedView view;
    view.name = numbered("view_", i);
    const double fraction = plan.views == 1 ? 0.5 : static_cast<double>(i) / (plan.views - 1);
    view.commanded_mm = fraction * rig.stage.travel().value();
    view.reached_mm =
        rig.stage.move_to(Length::of(view.commanded_mm), rig.clock.in(kMoveLimit)).value();
    LightsOffAtExit::all(rig, false);
    rig.leds.set_all(1);
    for (std::size_t e = 0; e < plan.exposures_s.size(); ++e)
      view.exposures.push_back(shoot("raw/" + view.name + "_exposure_" + std::to_string(e) + ".png",
                                     plan.exposures_s[e]));
    rig.leds.set_all(0);
    LightsOffAtExit::all(rig, true);
    view.marker_frame = shoot("raw/" + view.name + "_markers.png", plan.marker_exposure_s);
    views.push_back(view);
    dataset.write_frames(views);
  }
}

void record_alignments(const Rig& rig, const Dataset& dataset, int settings) {
  if (settings < 1) throw ArgumentError("an alignment needs at least one setting", "ask for one");
  std::vector<std::vector<Alignment>> all;
  for (DisplayId id : kDisplays) {
    std::vector<Alignment> marks;
    for (const auto* points : {&rig.near_cross_positions_rsb_mm, &rig.marker_positions_rsb_mm})
      for (const Eigen::Vector3d& p : *points) {
        Eigen::Vector2d sum = Eigen::Vector2d::Zero();
        for (int i = 0; i < settings; ++i)
          sum += rig.observer.align(id, p, rig.clock.in(kMoveLimit));
        marks.push_back({p, sum / settings});
      }
    all.push_back(marks);
  }
  dataset.write_landmarks({rig.marker_positions_rsb_mm, rig.near_cross_positions_rsb_mm});
  dataset.write_displays(rig.panel_models);
  dataset.write_alignments(all);
}

}  // namespace wheatstone
