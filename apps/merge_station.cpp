// From raw frames to HDR views, each made once and again when what it was made from changes.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "apps/stations.h"
#include "capture/exposure_check.h"
#include "capture/merge.h"
#include "capture/merged_exr.h"
#include "capture/merged_record.h"
#include "capture/raw_files.h"
#include "capture/session.h"
#include "core/csv.h"
#include "core/digest.h"
#include "core/error.h"
#include "core/files.h"
#include "core/json.h"
#include "core/png.h"

namespace wheatstone::apps {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

void require_capture(const Dataset& dataset) {
  if (const DatasetManifest manifest = dataset.read_manifest(); manifest.kind != "capture")
    throw FileError(dataset.file("dataset.json"), "is no capture but of kind " + manifest.kind,
                    "only captures are merged: name a folder that `wheatstone capture` has "
                    "finished");
}

/// One rectangle inside of the frames for every view, and none for others.
void require_patches(const MonitorPatches& patches, const std::vector<CapturedView>& views,
                     const Intrinsics& size) {
  for (const CapturedView& view : views) {
    const auto patch = patches.find(view.name);
    if (patch == patches.end())
      throw ArgumentError("there is no monitor patch for " + view.name, "add a line for it");
    const cv::Rect frame(0, 0, size.width_px, size.height_px);
    if (patch->second.empty() || (patch->second & frame) != patch->second)
      throw ArgumentError(view.name + ": the monitor patch is not inside of the view",
                          "correct its rectangle");
  }
  for (const auto& [name, patch] : patches)
    if (std::none_of(views.begin(), views.end(),
                     [&](const CapturedView& v) { return v.name == name; }))
      throw ArgumentError("there is a monitor patch for " + name + ", but no such view",
                          "correct the name or remove the line");
}

/// Share of the photosites whose light is at least `ratio` of its standard deviations.
double share_reaching(double ratio, const MergedMosaic& merged) {
  std::size_t reaching = 0;
  for (int r = 0; r < merged.flags.rows; ++r)
    for (int c = 0; c < merged.flags.cols; ++c)
      reaching += !(merged.flags(r, c) & kSaturated) &&
                  merged.mosaic.values(r, c) >= ratio * merged.sigma_dn_s(r, c);
  return static_cast<double>(reaching) / static_cast<double>(merged.flags.total());
}

double share_with(std::uint8_t flag, const MergedMosaic& merged) {
  return static_cast<double>(cv::countNonZero(merged.flags & flag)) /
         static_cast<double>(merged.flags.total());
}

/// Calls read(), whose ArgumentError is about this view.
template <class Read>
auto of_view(const CapturedView& view, const Read& read) {
  try {
    return read();
  } catch (const ArgumentError& e) {
    throw ArgumentError(view.name + ": " + e.what(), "");
  }
}

/// What makes of the raw frames of one dataset the light of one view.
class ViewMerger {
 public:
  /// The dataset, views and patches must outlive this.
  ViewMerger(const Dataset& dataset, const std::vector<CapturedView>& views,
             const MonitorPatches& patches)
      : dataset_(dataset),
        views_(views),
        patches_(patches),
        camera_(dataset.read_camera()),
        raw_(dataset) {
    if (!patches.empty()) require_patches(patches, views, camera_.intrinsics);
  }

  /// Fingerprint of all that the view's light depends on. Errors: as RawFiles::sha256().
  std::string made_from(const CapturedView& view) const {
    json inputs = {{"camera", camera_inputs()}, {"frames", frames_inputs(view)}};
    if (!patches_.empty())
      inputs["lamps"] = {{"patch", patch_input(view)},
                         {"reference_frames", frames_inputs(views_[0])},
                         {"reference_patch", patch_input(views_[0])}};
    const std::string text = inputs.dump();
    return sha256_hex(std::as_bytes(std::span(text)));
  }

  struct Made {
    MergedMosaic merged;
    std::optional<MergedRecord::Lamp> lamp;
  };
  /// Adds to `notes` what is odd about the exposures.
  Made make(const CapturedView& view, std::vector<std::string>& notes) {
    Made out{merged_exposures(view, &notes), std::nullopt};
    if (patches_.empty()) return out;
    LampCorrection correction;
    if (&view == &views_[0]) {
      first_ = read_patch(out.merged, view);
    } else {
      if (!first_) first_ = read_patch(merged_exposures(views_[0], nullptr), views_[0]);
      const PatchReading own = read_patch(out.merged, view);
      correction = of_view(view, [&] { return lamp_correction(*first_, own); });
    }
    out.merged.mosaic.values *= correction.factor;
    if (!out.merged.sigma_dn_s.empty()) out.merged.sigma_dn_s *= correction.factor;
    out.lamp = {correction, views_[0].name};
    return out;
  }

  const CameraProfile& camera() const { return camera_; }

 private:
  /// What merging uses of the profile; the lens is not among it.
  json camera_inputs() const {
    return {{"pattern", to_string(camera_.pattern)},
            {"black_dn", camera_.black_dn},
            {"white_dn", camera_.white_dn},
            {"dn_per_cd_m2_s", camera_.dn_per_cd_m2_s},
            {"camera_from_bt709", to_json(Eigen::MatrixXd(camera_.camera_from_bt709))},
            {"dn_per_electron", camera_.dn_per_electron},
            {"read_noise_e", camera_.read_noise_e},
            {"adc_noise", camera_.adc_noise}};
  }

  json frames_inputs(const CapturedView& view) const {
    json out = json::array();
    for (const ExposureRecord& e : view.exposures)
      out.push_back({{"sha256", raw_.sha256(e.file)}, {"exposure_s", e.exposure_s}});
    return out;
  }

  json patch_input(const CapturedView& view) const {
    const cv::Rect& patch = patches_.at(view.name);
    return {patch.x, patch.y, patch.width, patch.height};
  }

  MergedMosaic merged_exposures(const CapturedView& view, std::vector<std::string>* notes) const {
    std::vector<RawExposure> stack;
    std::vector<std::string> files;
    for (const ExposureRecord& e : view.exposures) {
      raw_.require(e.file);
      files.push_back(e.file);
      stack.push_back(
          {read_mosaic_png(dataset_.file(e.file), camera_.pattern), Duration::of(e.exposure_s), 1});
    }
    const MergeOptions options = merge_options(camera_);
    try {
      MergedMosaic merged = merge_exposures(stack, options);
      if (notes)
        for (const std::string& warning : exposure_warnings(stack, options, files))
          notes->push_back(warning);
      return merged;
    } catch (const ArgumentError& e) {
      throw FileError(dataset_.file("frames.json"), "view " + view.name + ": " + e.what(), "");
    }
  }

  PatchReading read_patch(const MergedMosaic& merged, const CapturedView& view) const {
    return of_view(view, [&] { return read_monitor_patch(merged, patches_.at(view.name)); });
  }

  const Dataset& dataset_;
  const std::vector<CapturedView>& views_;
  const MonitorPatches& patches_;
  CameraProfile camera_;
  RawFiles raw_;
  std::optional<PatchReading> first_;
};

/// Why the file must be made again; empty if the record fits both it and what it would be made
/// from.
std::string misfit(const std::optional<MergedRecord>& record, const std::string& made_from,
                   const fs::path& exr) {
  if (!record) return "there is no record of what it was made from";
  if (record->made_from != made_from)
    return "it was made from other frames, exposure times, camera or monitor patches";
  if (!holds_what_was_written(*record, exr)) return "it is not the file that was written";
  return "";
}

void keep_worst(const std::string& view, double share, ViewShare& worst) {
  if (worst.view.empty() || share > worst.share) worst = {view, share};
}

}  // namespace

MonitorPatches read_monitor_patches(const std::filesystem::path& file) {
  const CsvTable table = CsvTable::read(file);
  MonitorPatches out;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    std::array<int, 4> side{};
    constexpr std::array<const char*, 4> kNames = {"x_px", "y_px", "width_px", "height_px"};
    for (std::size_t k = 0; k < side.size(); ++k) {
      const double value = table.finite_number(i, kNames[k]);
      if (value != std::round(value) || std::abs(value) > 1e6)
        throw ArgumentError(table.where(i) + ": " + kNames[k] + " is no whole number of pixels",
                            "give the rectangle in pixels of the raw frame");
      side[k] = static_cast<int>(value);
    }
    if (!out.emplace(table.text(i, "view"), cv::Rect(side[0], side[1], side[2], side[3])).second)
      throw ArgumentError(table.where(i) + ": a second patch for " + table.text(i, "view"),
                          "give one line per view");
  }
  return out;
}

MergeReport merge(const Dataset& dataset, const Progress& progress, Shard shard,
                  const MonitorPatches& patches) {
  require_capture(dataset);
  const std::vector<CapturedView> views = dataset.read_frames();
  ViewMerger merger(dataset, views, patches);
  std::vector<const CapturedView*> mine;
  for (std::size_t k = 0; k < views.size(); ++k)
    if (shard.holds(k)) mine.push_back(&views[k]);
  MergeReport report;
  report.views_of_folder = static_cast<int>(views.size());
  if (const std::optional<CapturePlan> plan = recorded_plan(dataset)) {
    report.signal_to_noise = plan->signal_to_noise;
    report.coverage = plan->coverage;
  }
  if (!mine.empty()) make_folder(dataset.file("hdr"));
  for (std::size_t i = 0; i < mine.size(); ++i) {
    const CapturedView& view = *mine[i];
    const fs::path exr = dataset.file("hdr/" + view.name + ".exr");
    const fs::path record_file = dataset.file("hdr/" + view.name + ".json");
    const std::string made_from = merger.made_from(view);
    std::optional<MergedRecord> record = read_merged_record(record_file);
    const std::string why = misfit(record, made_from, exr);
    if (why.empty()) {
      ++report.there_already;
    } else {
      if (fs::exists(exr)) report.notes.push_back(exr.string() + ": merged again, because " + why);
      const ViewMerger::Made made = merger.make(view, report.notes);
      write_merged_light_exr(exr, made.merged, merger.camera());
      record = {made_from,
                fs::file_size(exr),
                sha256_hex_of(exr),
                share_with(kSaturated, made.merged),
                share_with(kUnderexposed, made.merged),
                made.lamp};
      write_merged_record(record_file, *record);
      ++report.merged;
      if (report.signal_to_noise > 0)
        report.least_share =
            std::min(report.least_share, share_reaching(report.signal_to_noise, made.merged));
    }
    keep_worst(view.name, record->saturated, report.most_saturated);
    keep_worst(view.name, record->underexposed, report.most_underexposed);
    progress("merge", static_cast<int>(i) + 1, static_cast<int>(mine.size()));
  }
  return report;
}

}  // namespace wheatstone::apps
