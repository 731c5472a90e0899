#include "capture/merge.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>

#include "apps/commands/commands.h"
#include "apps/commands/common.h"
#include "apps/stations.h"
#include "capture/deglare.h"
#include "capture/exposure_check.h"
#include "capture/exposure_stack.h"
#include "capture/merged_exr.h"
#include "core/error.h"
#include "core/text.h"

namespace wheatstone::apps {
namespace {

void merge_frames(const std::string& frames_json, const std::string& glare, bool demosaic,
                  const std::string& out) {
  const std::optional<GlareMtf> mtf =
      glare.empty() ? std::nullopt : std::optional(read_glare_mtf(glare));
  const ExposureStack stack = read_exposure_stack(frames_json);
  MergedMosaic merged;
  try {
    merged = merge_exposures(stack.exposures, stack.merging);
  } catch (const ArgumentError& e) {
    throw FileError(frames_json, e.what(), "");
  }
  if (mtf) {
    try {
      merged.mosaic = remove_glare(merged.mosaic, *mtf);
    } catch (const ArgumentError& e) {
      throw FileError(glare, e.what(), "");
    }
    fmt::print(stderr,
               "glare of the lens taken out; sigma.Y is that of the light before, and shadows are "
               "noisier now\n");
  }
  std::vector<std::string> files;
  for (const auto& file : stack.files) files.push_back(file.string());
  for (const std::string& warning : exposure_warnings(stack.exposures, stack.merging, files))
    fmt::print(stderr, "warning: {}\n", warning);
  if (demosaic)
    write_merged_camera_exr(out, merged);
  else
    write_merged_mosaic_exr(out, merged);
  if (!stack.merging.noise)
    fmt::print(stderr, "{}: no \"noise\", so {} has no sigma.Y and no mask.underexposed\n",
               frames_json, out);
  fmt::print("wrote {}\n", out);
}

void warn_above_limit(const ViewShare& worst, const char* what, const char* remedy) {
  constexpr double kLimit = 0.01;
  if (worst.share > kLimit)
    fmt::print(stderr, "warning: {:.3g} % of the pixels of {} are {}; {}\n", 100 * worst.share,
               worst.view, what, remedy);
}

void merge_dataset(const std::string& folder, const std::string& shard,
                   const std::string& monitor_patches) {
  const MonitorPatches patches =
      monitor_patches.empty() ? MonitorPatches{} : read_monitor_patches(monitor_patches);
  const MergeReport r =
      merge(open_dataset(folder), show_progress, shard_from_string(shard), patches);
  for (const std::string& note : r.notes) fmt::print(stderr, "warning: {}\n", note);
  const int mine = r.merged + r.there_already;
  if (mine == 0) {
    fmt::print("shard {} holds none of the {}: there is nothing to do\n", shard,
               counted(r.views_of_folder, "view"));
    return;
  }
  fmt::print("hdr: {} of {} merged, {} there already\n", r.merged, counted(mine, "view"),
             r.there_already);
  fmt::print("at most {:.2f} % of a view ({}) are saturated, {:.2f} % ({}) underexposed\n",
             100 * r.most_saturated.share, r.most_saturated.view, 100 * r.most_underexposed.share,
             r.most_underexposed.view);
  warn_above_limit(r.most_saturated, "saturated even in the shortest exposure",
                   "their light is a lower bound; capture with a shorter exposure");
  warn_above_limit(r.most_underexposed, "underexposed even in the longest exposure",
                   "they are noise; capture with a longer exposure");
  if (r.merged > 0 && r.signal_to_noise > 0)
    fmt::print(
        "a signal-to-noise ratio of {} in at least {:.1f} % of each of {}; {:.1f} % "
        "were asked for{}\n",
        r.signal_to_noise, 100 * r.least_share, counted(r.merged, "view"), 100 * r.coverage,
        r.least_share < r.coverage ? ": MISSED" : "");
}

}  // namespace

void add_merge(CLI::App& app) {
  auto* command = app.add_subcommand(
      "merge", "Merge raw exposures to HDR: a dataset's views in cd/m², or one stack in DN/s");
  struct Options {
    std::string dataset, frames, glare, monitor_patches, out, shard = "1/1";
    bool no_demosaic = false;
  };
  auto o = std::make_shared<Options>();
  auto* dataset = command->add_option("dataset", o->dataset, "dataset folder");
  auto* frames = command->add_option("--frames", o->frames, "stack (docs/hdr_merge.md)");
  auto* out = command->add_option("--out", o->out, "EXR for the merged stack");
  auto* no_demosaic =
      command->add_flag("--no-demosaic", o->no_demosaic, "write the mosaic itself, channel Y");
  auto* shard =
      command->add_option("--shard", o->shard, "i/N: only every Nth view, from the ith on")
          ->needs(dataset);
  command
      ->add_option("--monitor-patch", o->monitor_patches,
                   "CSV: where each view shows the patch that tells the lamps' drift "
                   "(docs/hdr_merge.md)")
      ->needs(dataset);
  command->add_option("--glare-mtf", o->glare, "take the lens's glare out (docs/hdr_merge.md)")
      ->needs(frames);
  dataset->excludes(frames)->excludes(out);
  frames->needs(out);
  out->needs(frames);
  no_demosaic->needs(frames)->excludes(shard);
  command->footer(
      "Example:\n  wheatstone merge out/card\n"
      "  wheatstone merge out/card --shard 3/16\n"
      "  wheatstone merge --frames frames.json --out merged.exr");
  command->callback([=] {
    if (!o->frames.empty()) {
      require_other_file(o->out, {o->frames, o->glare});
      require_exr_name(o->out);
      merge_frames(o->frames, o->glare, !o->no_demosaic, o->out);
    } else if (!o->dataset.empty()) {
      merge_dataset(o->dataset, o->shard, o->monitor_patches);
    } else {
      throw ArgumentError("nothing to merge", "name a dataset folder, or --frames and --out");
    }
  });
}

}  // namespace wheatstone::apps
