#include "capture/plan.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "core/error.h"
#include "core/json.h"

namespace wheatstone {

using nlohmann::json;

std::string validate(const CapturePlan& plan) {
  const auto is_time = [](double t) { return t > 0 && std::isfinite(t); };
  if (plan.views < 1) return "a capture needs at least one view";
  if (plan.views > 999) return "a capture takes at most 999 views";
  if (plan.exposures_s.empty()) return "a capture needs at least one exposure";
  for (const double t : plan.exposures_s)
    if (!is_time(t)) return "exposure times must be above 0 s";
  if (std::set<double>(plan.exposures_s.begin(), plan.exposures_s.end()).size() !=
      plan.exposures_s.size())
    return "an exposure time is there twice";
  if (!is_time(plan.marker_exposure_s)) return "the marker exposure must be above 0 s";
  if (!(plan.settle_s >= 0 && std::isfinite(plan.settle_s))) return "the rest must be 0 s or more";
  return "";
}

void require_possible(const CapturePlan& plan, const Rig& rig) {
  if (const std::string reason = validate(plan); !reason.empty())
    throw ArgumentError(reason, "change the plan");
  for (const double t : plan.exposures_s) rig.camera->offered_exposure(Duration::of(t));
  rig.camera->offered_exposure(Duration::of(plan.marker_exposure_s));
}

json to_json(const CapturePlan& plan) {
  return {{"views", plan.views},
          {"exposures_s", plan.exposures_s},
          {"marker_exposure_s", plan.marker_exposure_s},
          {"settle_s", plan.settle_s},
          {"signal_to_noise", plan.signal_to_noise},
          {"coverage", plan.coverage}};
}

CapturePlan plan_from_json(const json& j, const std::filesystem::path& file) {
  return {json_get<int>(j, "views", file),
          json_get<std::vector<double>>(j, "exposures_s", file),
          json_get<double>(j, "marker_exposure_s", file),
          json_get<double>(j, "settle_s", file),
          json_get<double>(j, "signal_to_noise", file),
          json_get<double>(j, "coverage", file)};
}

std::string difference(const json& there, const json& asked) {
  const json a = there.flatten(), b = asked.flatten();
  std::set<std::string> names;
  for (const json* side : {&a, &b})
    for (const auto& item : side->items()) names.insert(item.key());
  const auto shown = [](const json& side, const std::string& name) {
    return side.contains(name) ? side[name].dump() : std::string("nothing");
  };
  std::string lines;
  for (const std::string& name : names)
    if (shown(a, name) != shown(b, name))
      lines += fmt::format("\n  {}: {} there, {} asked for", name.substr(1), shown(a, name),
                           shown(b, name));
  return lines;
}

std::vector<Shot> shots_of(const CapturePlan& plan, Length travel) {
  std::vector<Shot> shots;
  for (int i = 0; i < plan.views; ++i) {
    Shot shot;
    shot.view = fmt::format("view_{:03}", i);
    shot.position = (plan.views == 1 ? 0.5 : static_cast<double>(i) / (plan.views - 1)) * travel;
    for (std::size_t e = 0; e < plan.exposures_s.size(); ++e) {
      shot.file = fmt::format("raw/{}_exposure_{}.png", shot.view, e);
      shot.exposure_s = plan.exposures_s[e];
      shots.push_back(shot);
    }
    shot.light = Shot::Light::kMarkers;
    shot.file = fmt::format("raw/{}_markers.png", shot.view);
    shot.exposure_s = plan.marker_exposure_s;
    shots.push_back(shot);
  }
  if (plan.views > 1)
    shots.push_back({kReturnView, "raw/return_markers.png", Length::of(0),
                     Shot::Approach::kFromAbove, Shot::Light::kMarkers, plan.marker_exposure_s});
  return shots;
}

CaptureForecast forecast(const std::vector<Shot>& shots, const CapturePlan& plan, const Rig& rig) {
  CaptureForecast out;
  double position_mm = 0;
  const Shot* before = nullptr;
  for (const Shot& shot : shots) {
    if (!before || before->view != shot.view) {
      const double mm = std::abs(shot.position.value() - position_mm);
      out.duration_s += rig.stage->move_duration(Length::of(mm)).value() + plan.settle_s;
      position_mm = shot.position.value();
    }
    out.duration_s += rig.camera->frame_duration(Duration::of(shot.exposure_s)).value();
    ++out.frames;
    before = &shot;
  }
  const Intrinsics& k = rig.camera_profile.intrinsics;
  const auto photosites =
      static_cast<std::uintmax_t>(k.width_px) * static_cast<std::uintmax_t>(k.height_px);
  out.bytes = static_cast<std::uintmax_t>(out.frames) *
              (2 * photosites + rig.camera->largest_file(photosites));
  return out;
}

}  // namespace wheatstone
