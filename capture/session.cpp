#include "capture/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <span>
#include <utility>

#include "calib/markers.h"
#include "capture/session_record.h"
#include "core/digest.h"
#include "core/error.h"
#include "core/files.h"
#include "core/json.h"
#include "core/png.h"

namespace wheatstone {

namespace fs = std::filesystem;
using detail::SessionRecord;
using detail::TakenFrame;
using nlohmann::json;

namespace {

constexpr double kPositionToleranceMm = 0.5;  // reached against commanded
constexpr double kSamePlaceMm = 0.02;         // frames of one view: a tenth of a pixel
constexpr double kExposureTolerance = 0.12;   // nominal times are rounded by up to a sixth stop
constexpr double kReadoutS = 2;               // after which a closed shutter is surely closed

/// Fit to end a name beside the frame's own ".png".
bool is_type_of_camera_file(const std::string& type) {
  constexpr std::size_t kLongest = 8;
  return !type.empty() && type.size() <= kLongest && type != "png" &&
         std::all_of(type.begin(), type.end(), [](unsigned char c) { return std::isalnum(c); });
}

json setup_of(const Rig& rig, const DatasetManifest& manifest, const CapturePlan& plan) {
  const Intrinsics& k = rig.camera_profile.intrinsics;
  return {{"plan", to_json(plan)},
          {"camera",
           {{"serial", rig.camera_profile.serial},
            {"width_px", k.width_px},
            {"height_px", k.height_px}}},
          {"travel_mm", rig.stage->travel().value()},
          {"ceiling_drive", rig.leds->max_mean_drive()},
          {"scene", manifest.scene},
          {"seed", manifest.seed},
          {"scale", manifest.scale},
          {"source", manifest.source}};
}

/// Where the camera stood at the second marker frame of the first position, relative to the first.
json return_check(const Rig& rig, const Dataset& dataset, const Shot& first, const Shot& last,
                  double encoder_mm) {
  const auto centres = [&](const Shot& shot) {
    const fs::path file = dataset.file(shot.file);
    return order_markers(
        find_markers(read_mosaic_png(file, rig.camera_profile.pattern), rig.camera_profile),
        file.string());
  };
  json check = {{"file", last.file}, {"encoder_mm", encoder_mm}};
  try {
    const auto before = centres(first), after = centres(last);
    // The camera looks along the box's axis: a move to the right shifts all markers to the left.
    const double px_per_mm =
        (before[1].centroid_px - before[0].centroid_px).norm() /
        (rig.marker_positions_rsb_mm[1] - rig.marker_positions_rsb_mm[0]).norm();
    double shift_px = 0;
    for (std::size_t i = 0; i < before.size(); ++i)
      shift_px += (after[i].centroid_px.x() - before[i].centroid_px.x()) /
                  static_cast<double>(before.size());
    check["seen_mm"] = -shift_px / px_per_mm;
  } catch (const ArgumentError& e) {
    check["problem"] = e.what();  // the frames stay: the operator decides
  }
  return check;
}

/// Why no pose will be found from this marker frame; empty if one can be.
std::string marker_problem(const CameraProfile& camera, const MosaicImage& frame,
                           const std::string& file) {
  try {
    order_markers(find_markers(frame, camera), file);
    return "";
  } catch (const ArgumentError& e) {
    return e.what();
  }
}

class Session {
 public:
  Session(const Rig& rig, const Dataset& dataset, const DatasetManifest& manifest,
          const CapturePlan& plan, const CaptureListener& listener)
      : rig_(rig),
        dataset_(dataset),
        manifest_(manifest),
        plan_(plan),
        listener_(listener),
        shots_(shots_of(plan, rig.stage->travel())),
        record_(dataset, setup_of(rig, manifest, plan), listener.on_record) {}
  void run() try {
    for (const char* folder : {"", "raw", "session"}) remove_unfinished(dataset_.file(folder));
    record_.verify();
    if (!record_.complete(shots_)) {
      unfinish();
      require_space();
      prepare();
      for (std::size_t i = 0; i < shots_.size();) i = take_view(i);
    }
    finish();
  } catch (const Error& e) {
    try {
      record_.add("stopped", {{"why", e.what()}});
    } catch (const Error&) {  // the disk may be the reason
    }
    throw;
  }

 private:
  void stop_if_asked() const {
    if (listener_.stop.stop_requested()) throw Cancelled("capture stopped");
  }

  /// For something that should take so long.
  Deadline patience(Duration expected = {}) const {
    return deadline_for(rig_.clock, expected, listener_.stop);
  }

  /// Not a finished capture any more.
  void unfinish() const {
    std::error_code error;
    fs::remove(dataset_.file("dataset.json"), error);
    if (error)
      throw FileError(dataset_.file("dataset.json"), "cannot be removed (" + error.message() + ")",
                      "make the folder writable");
  }

  void require_space() const {
    std::vector<Shot> missing;
    for (const Shot& s : shots_)
      if (!record_.taken(s)) missing.push_back(s);
    const std::uintmax_t needed = forecast(missing, plan_, rig_).bytes;
    std::error_code error;  // then the largest number there is: writing will tell
    const std::uintmax_t free = fs::space(dataset_.root(), error).available;
    if (needed > free)
      throw FileError(
          dataset_.root(),
          fmt::format("the frames need up to {:.1f} MB, the disk has {:.1f} MB left",
                      static_cast<double>(needed) / 1e6, static_cast<double>(free) / 1e6),
          "free space on this disk, then run the command again");
  }

  void prepare() {
    make_folder(dataset_.file("raw"));
    dataset_.write_camera(rig_.camera_profile);
    dataset_.write_landmarks({rig_.marker_positions_rsb_mm, rig_.near_cross_positions_rsb_mm});
    if (!rig_.panel_models.empty()) dataset_.write_displays(rig_.panel_models);
    make_safe(rig_);
    stop_if_asked();
    if (const double t = record_.unfinished_exposure_s(); t > 0)
      rig_.clock.wait_until(rig_.clock.in(Duration::of(t + kReadoutS)).at_ns);
    position_ = rig_.stage->home(patience(rig_.stage->home_duration()));
    record_.add("homed", {{"reached_mm", position_.value()}});
  }

  /// All that is missing of the view that begins with shot `begin`; returns the next view's first.
  std::size_t take_view(std::size_t begin) {
    std::size_t end = begin;
    while (end < shots_.size() && shots_[end].view == shots_[begin].view) ++end;
    const std::span<const Shot> view(&shots_[begin], end - begin);
    const auto taken = [&](const Shot& s) { return record_.taken(s) != nullptr; };
    if (!std::all_of(view.begin(), view.end(), taken)) {
      stop_if_asked();
      const Length reached = go_to(view.front());
      for (const Shot& s : view) {
        if (!taken(s)) continue;
        const double before_mm = record_.taken(s)->reached_mm;
        if (std::abs(before_mm - reached.value()) > kSamePlaceMm)
          record_.set_aside(
              s.file, fmt::format("was taken at {} mm, the carriage now reaches {} mm", before_mm,
                                  reached.value()));
      }
      for (const Shot& s : view)
        if (!taken(s)) take(s, reached);
    } else {
      report_progress();
    }
    return end;
  }

  Length go_to(const Shot& shot) {
    // Towards the position from the shot's side, whatever stood before.
    const bool from_above = shot.approach == Shot::Approach::kFromAbove;
    if (from_above && position_ <= shot.position) move_to(rig_.stage->travel());
    if (!from_above && position_ > shot.position) move_to(Length::of(0));
    const Length reached = move_to(shot.position);
    rig_.clock.wait_until(rig_.clock.in(Duration::of(plan_.settle_s)).at_ns);
    return reached;
  }

  Length move_to(Length target) {
    position_ =
        rig_.stage->move_to(target, patience(rig_.stage->move_duration(rig_.stage->travel())));
    const double half_step_mm = rig_.stage->resolution().value() / 2;
    if (std::abs(position_.value() - target.value()) > kPositionToleranceMm + half_step_mm)
      throw DeviceError(DeviceError::Kind::kFault,
                        fmt::format("the carriage stands at {:.3f} mm instead of {:.3f} mm",
                                    position_.value(), target.value()),
                        "free the rail, then run the command again");
    return position_;
  }

  void set_light(Shot::Light light) {
    const bool markers = light == Shot::Light::kMarkers;
    if (markers) rig_.leds->set_all(0, patience());
    rig_.markers->set(markers ? rig_.markers->all() : 0, patience());
    if (!markers) rig_.leds->set_all(rig_.leds->max_mean_drive(), patience());
  }

  void take(const Shot& shot, Length reached) {
    stop_if_asked();
    set_light(shot.light);
    const Nanoseconds asked_ns = rig_.clock.now_ns();
    json frame = {{"file", shot.file},
                  {"view", shot.view},
                  {"commanded_mm", shot.position.value()},
                  {"reached_mm", reached.value()},
                  {"light", shot.light == Shot::Light::kMarkers ? "markers" : "ceiling"},
                  {"exposure_s", shot.exposure_s}};
    record_.add("trigger", frame);
    const Duration exposure = Duration::of(shot.exposure_s);
    const RawFrame raw =
        rig_.camera->expose(exposure, patience(rig_.camera->frame_duration(exposure)));
    require_the_frame(raw, shot, asked_ns);
    if (!raw.file.empty()) {
      const std::string file = fs::path(shot.file).replace_extension(raw.file_type).string();
      write_bytes_atomically(dataset_.file(file), raw.file);
      frame["camera_file"] = {
          {"file", file}, {"bytes", raw.file.size()}, {"sha256", sha256_hex(raw.file)}};
    }
    write_mosaic_png(dataset_.file(shot.file), raw.mosaic);
    frame["exposure_s"] = raw.exposure.value();
    frame["gain"] = raw.gain;
    frame["camera_serial"] = raw.camera_serial;
    frame["triggered_ns"] = raw.triggered_ns;
    const std::vector<std::byte> written = read_bytes(dataset_.file(shot.file));
    frame["bytes"] = written.size();
    frame["sha256"] = sha256_hex(written);
    record_.add("frame", frame);
    if (shot.light == Shot::Light::kMarkers && !std::exchange(markers_looked_at_, true))
      if (const std::string problem = marker_problem(rig_.camera_profile, raw.mosaic, shot.file);
          !problem.empty())
        record_.add("markers", {{"file", shot.file}, {"problem", problem}});
    report_progress();
  }

  void require_the_frame(const RawFrame& raw, const Shot& shot, Nanoseconds asked_ns) const {
    const CameraProfile& profile = rig_.camera_profile;
    const auto refuse = [&](const std::string& problem, const std::string& remedy) {
      throw DeviceError(DeviceError::Kind::kFault, "for " + shot.file + " " + problem, remedy);
    };
    if (raw.triggered_ns < asked_ns)
      refuse("the camera handed over an older frame",
             "empty the camera's card, then run the command again");
    if (raw.camera_serial != profile.serial)
      refuse(fmt::format("a frame of camera '{}' came instead of '{}'", raw.camera_serial,
                         profile.serial),
             "connect the camera that this session began with");
    if (std::abs(raw.exposure.value() / shot.exposure_s - 1) > kExposureTolerance)
      refuse(fmt::format("the camera exposed for {} s instead of {} s", raw.exposure.value(),
                         shot.exposure_s),
             "set the camera to manual exposure");
    if (raw.gain != 1)
      refuse(fmt::format("the camera used ISO {}", 100 * raw.gain), "set the camera to ISO 100");
    if (raw.mosaic.width() != profile.intrinsics.width_px ||
        raw.mosaic.height() != profile.intrinsics.height_px ||
        raw.mosaic.pattern != profile.pattern)
      refuse(fmt::format("the camera delivered {}x{} pixels, {}", raw.mosaic.width(),
                         raw.mosaic.height(), to_string(raw.mosaic.pattern)),
             "set the camera to its full raw format");
    if (!raw.file.empty() && !is_type_of_camera_file(raw.file_type))
      refuse(fmt::format("the camera's file is of type '{}'", raw.file_type),
             "set the camera to raw files");
  }

  void report_progress() {
    if (!listener_.on_progress) return;
    const auto done = std::count_if(shots_.begin(), shots_.end(),
                                    [&](const Shot& s) { return record_.taken(s); });
    listener_.on_progress(static_cast<int>(done), static_cast<int>(shots_.size()));
  }

  void finish() {
    if (fs::exists(dataset_.file("dataset.json"))) return;
    std::vector<CapturedView> views;
    for (const Shot& shot : shots_) {
      if (shot.view == kReturnView) continue;
      const TakenFrame& frame = *record_.taken(shot);
      if (views.empty() || views.back().name != shot.view)
        views.push_back({shot.view, frame.commanded_mm, frame.reached_mm, {}, {}});
      const ExposureRecord exposure{shot.file, frame.exposure_s};
      if (shot.light == Shot::Light::kMarkers)
        views.back().marker_frame = exposure;
      else
        views.back().exposures.push_back(exposure);
    }
    dataset_.write_frames(views);
    if (shots_.back().view == kReturnView) {
      const Shot& first = *std::find_if(shots_.begin(), shots_.end(), [](const Shot& s) {
        return s.light == Shot::Light::kMarkers;
      });
      record_.add("returned", return_check(rig_, dataset_, first, shots_.back(),
                                           record_.taken(shots_.back())->reached_mm -
                                               record_.taken(first)->reached_mm));
    }
    dataset_.write_manifest(manifest_);
    record_.add("finished", {{"frames", shots_.size()}});
  }

  const Rig& rig_;
  const Dataset& dataset_;
  const DatasetManifest& manifest_;
  const CapturePlan& plan_;
  const CaptureListener& listener_;
  const std::vector<Shot> shots_;
  SessionRecord record_;
  Length position_;  // as the stage last said
  bool markers_looked_at_ = false;
};

std::vector<json> journal_of(const Dataset& dataset) {
  const fs::path file = dataset.file(detail::kJournalFile);
  return fs::exists(file) ? Journal::read(file) : std::vector<json>();
}

}  // namespace

void capture_light_field(const Rig& rig, const Dataset& dataset, const DatasetManifest& manifest,
                         const CapturePlan& plan, const CaptureListener& listener) {
  require_possible(plan, rig);
  const SafeAtExit guard(rig);
  Session(rig, dataset, manifest, plan, listener).run();
}

std::optional<CapturePlan> recorded_plan(const Dataset& dataset) {
  const std::vector<json> records = journal_of(dataset);
  if (records.empty()) return std::nullopt;
  const fs::path file = dataset.file(detail::kJournalFile);
  return plan_from_json(json_get<json>(records.front(), "plan", file), file);
}

std::vector<Shot> missing_shots(const Rig& rig, const Dataset& dataset,
                                const DatasetManifest& manifest, const CapturePlan& plan) {
  const std::vector<json> records = journal_of(dataset);
  if (!records.empty())
    detail::require_same_setup(dataset, records.front(), setup_of(rig, manifest, plan));
  const auto taken = detail::taken_frames(dataset, records);
  std::vector<Shot> missing = shots_of(plan, rig.stage->travel());
  std::erase_if(missing, [&](const Shot& s) { return taken.contains(s.file); });
  return missing;
}

}  // namespace wheatstone
