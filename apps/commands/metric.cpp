#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "apps/commands/commands.h"
#include "apps/commands/common.h"
#include "apps/scoring.h"
#include "core/csv.h"
#include "core/error.h"
#include "rendering/metrics/flicker.h"
#include "rendering/metrics/pu21.h"

namespace wheatstone::apps {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct MetricArguments {
  std::string test, reference, mask, map, out, shard;
  std::vector<int> region;
  double ppd = 0, pixel_pitch_mm = 0, distance_mm = 0, peak_cd_m2 = 0;
  bool as_json = false;
  ScoreOptions score;
};

/// One line for people: a value with its unit, or what infinity means.
std::string readable(double value, const std::string& unit) {
  if (std::isinf(value)) return "inf (identical)";
  return fmt::format("{:.4f}{}{}", value, unit.empty() ? "" : " ", unit);
}

void score_one(const MetricArguments& a) {
  const Score score = score_pair(a.test, a.reference, a.score, !a.map.empty());
  if (!a.map.empty()) write_map(a.map, score, a.score.metric);
  if (a.as_json) {
    json out = a.score.settings();
    out.update(score.details.is_null() ? json::object() : score.details);
    out["value"] = json_number(score.value);
    out["unit"] = unit_of(a.score.metric);
    fmt::print("{}\n", out.dump(2));
    return;
  }
  fmt::print("{} {}\n", a.score.metric, readable(score.value, unit_of(a.score.metric)));
  for (const auto& [name, value] : score.details.items())
    fmt::print("  {} {:.6g}\n", name, value.get<double>());
}

void write_table(const fs::path& path, const std::vector<NamedScore>& scores,
                 const std::string& unit) {
  CsvTable table({"name"});
  std::vector<double> values;
  for (const NamedScore& s : scores) {
    table.add_row({s.name});
    values.push_back(s.value);
  }
  table.set_column(unit == "dB" ? "value_db" : unit == "JOD" ? "value_jod" : "value", values);
  table.write(path);
}

void score_all(const MetricArguments& a) {
  if (!a.map.empty())
    throw ArgumentError("--map is for one pair of pictures", "name two files, or leave it out");
  if (!a.shard.empty() && a.out.empty())
    throw ArgumentError("--shard without --out would lose its results", "name a folder with --out");
  const auto results = a.out.empty() ? std::nullopt : std::optional<fs::path>(a.out);
  const Shard shard = a.shard.empty() ? Shard() : shard_from_string(a.shard);
  const std::vector<NamedScore> scores =
      score_folder(pairs_in(a.test, a.reference), a.score, shard, results,
                   [&](int done, int total) { show_progress(a.score.metric, done, total); });
  const std::string unit = unit_of(a.score.metric);
  if (results && a.shard.empty()) write_table(*results / "scores.csv", scores, unit);
  const Summary summary = summarise(scores);
  if (a.as_json) {
    json out = a.score.settings();
    out["unit"] = unit;
    out["pairs"] = json::array();
    for (const NamedScore& s : scores)
      out["pairs"].push_back({{"name", s.name}, {"value", json_number(s.value)}});
    out["identical_pairs"] = summary.identical;
    out["mean"] = summary.mean ? json(*summary.mean) : json();
    out["standard_deviation"] =
        summary.standard_deviation ? json(*summary.standard_deviation) : json();
    fmt::print("{}\n", out.dump(2));
    return;
  }
  std::size_t width = 4;
  for (const NamedScore& s : scores) width = std::max(width, s.name.size());
  for (const NamedScore& s : scores)
    fmt::print("{:<{}}  {}\n", s.name, width, readable(s.value, unit));
  if (summary.mean)
    fmt::print("{:<{}}  {}{}\n", "mean", width, readable(*summary.mean, unit),
               summary.standard_deviation
                   ? fmt::format(", standard deviation {:.4f}", *summary.standard_deviation)
                   : "");
}

/// Frames are the pairs of two folders in the order of their names.
void score_flicker(const MetricArguments& a) {
  if (!a.map.empty() || !a.shard.empty() || !a.out.empty() || a.score.mask || a.score.region ||
      a.score.pixels_per_degree || a.score.channels == "y")
    throw ArgumentError("flicker takes two folders of frames and their scale only",
                        "leave out --map, --shard, --out, --mask, --roi, --ppd and --channel");
  const std::vector<Pair> frames = pairs_in(a.test, a.reference);
  FlickerMeter meter;
  for (const Pair& frame : frames) {
    try {
      meter.add(read_light(frame.test, a.score.light), read_light(frame.reference, a.score.light));
    } catch (const ArgumentError& e) {
      throw ArgumentError(frame.test.string() + ": " + e.what(), "");
    }
    show_progress("flicker", meter.frames(), static_cast<int>(frames.size()));
  }
  if (a.as_json)
    fmt::print("{}\n", json({{"metric", "flicker"},
                             {"value", meter.flicker_pu()},
                             {"unit", "PU21 units"},
                             {"frames", meter.frames()},
                             {"steps_pu", meter.steps_pu()}})
                           .dump(2));
  else
    fmt::print("flicker {:.4f} PU21 units over {} frames\n", meter.flicker_pu(), meter.frames());
}

void run_metric(const CLI::App& command, MetricArguments a) {
  for (const char* needed : {"--test", "--reference", "--metric"})
    if (command.count(needed) == 0) throw CLI::RequiredError(needed);
  if (command.count("--ppd") > 0) a.score.pixels_per_degree = a.ppd;
  const bool pitch = command.count("--pixel-pitch-mm") > 0,
             far = command.count("--distance-mm") > 0;
  if (pitch != far || (pitch && a.score.pixels_per_degree))
    throw ArgumentError("the pixels per degree are not clear",
                        "give --ppd, or both --pixel-pitch-mm and --distance-mm");
  if (pitch)
    a.score.pixels_per_degree =
        pixels_per_degree(Length::of(a.pixel_pitch_mm), Length::of(a.distance_mm));
  if (command.count("--peak-cd-m2") > 0) a.score.light.peak_cd_m2 = a.peak_cd_m2;
  if (!a.mask.empty()) a.score.mask = a.mask;
  if (!a.region.empty())
    a.score.region = cv::Rect(a.region[0], a.region[1], a.region[2], a.region[3]);
  const bool folders = fs::is_directory(a.test);
  if (folders != fs::is_directory(a.reference))
    throw ArgumentError("one of --test and --reference is a folder, the other is not",
                        "name two pictures or two folders");
  if (a.score.metric == "flicker") {
    if (!folders) throw ArgumentError("flicker needs folders of frames", "name two folders");
    score_flicker(a);
  } else if (folders) {
    score_all(a);
  } else {
    if (!a.shard.empty() || !a.out.empty())
      throw ArgumentError("--shard and --out are for folders", "name two folders");
    score_one(a);
  }
}

void add_pu21(CLI::App& metric) {
  auto* command = metric.add_subcommand("pu21", "Encode a table of luminances with PU21");
  auto variant = std::make_shared<std::string>("banding_glare");
  auto input = std::make_shared<std::string>(), output = std::make_shared<std::string>();
  command->add_option("--variant", *variant, "banding, banding_glare, peaks or peaks_glare")
      ->capture_default_str();
  command->add_option("--input", *input, "CSV with a column luminance_cd_m2")->required();
  command->add_option("--output", *output, "the same with pu21_value and decoded_cd_m2")
      ->required();
  command->footer("Example:\n  wheatstone metric pu21 --input in.csv --output out.csv");
  command->callback([=] {
    const Pu21Variant curve = pu21_variant_from_string(*variant);
    CsvTable table = CsvTable::read(*input);
    std::vector<double> encoded, decoded;
    for (std::size_t row = 0; row < table.rows(); ++row) {
      const double light = table.finite_number(row, "luminance_cd_m2");
      if (light < 0)
        throw FileError(table.where(row), "column 'luminance_cd_m2' is negative",
                        "give luminances of at least 0");
      encoded.push_back(pu21_encode(light, curve));
      decoded.push_back(pu21_decode(encoded.back(), curve));
    }
    if (encoded.empty()) throw FileError(*input, "has no rows", "give a luminance in each row");
    table.set_column("pu21_value", encoded);
    table.set_column("decoded_cd_m2", decoded);
    table.write(*output);
  });
}

}  // namespace

void add_metric(CLI::App& app) {
  auto* command = app.add_subcommand("metric", "How much a picture differs from its reference");
  auto a = std::make_shared<MetricArguments>();
  GogDisplay& display = a->score.light.display;
  command->add_option("--test", a->test, "picture, or a folder of them");
  command->add_option("--reference", a->reference, "picture, or a folder with the same names");
  command->add_option("--metric", a->score.metric, "how to compare them")
      ->check(CLI::IsMember({"pu21-psnr", "pu21-ssim", "ms-ssim", "hdr-vdp3", "flicker"}));
  command->add_option("--channel", a->score.channels, "rgb or y; rgb for pu21-psnr, else y")
      ->check(CLI::IsMember({"rgb", "y"}));
  command->add_option("--ppd", a->ppd, "pixels per degree of visual angle (hdr-vdp3)");
  command->add_option("--pixel-pitch-mm", a->pixel_pitch_mm, "instead of --ppd");
  command->add_option("--distance-mm", a->distance_mm, "of the eye, with --pixel-pitch-mm");
  command->add_option("--mask", a->mask, "picture; only its pixels above 0 count");
  command->add_option("--roi", a->region, "x,y,width,height: score this region alone")
      ->delimiter(',')
      ->expected(4);
  command->add_option("--map", a->map, "write what differs where: .exr, or .png in false colour");
  command->add_option("--peak-cd-m2", a->peak_cd_m2,
                      "light of value 1, or of full code in integer pictures, where the file does "
                      "not say it");
  command->add_flag("--absolute", a->score.light.absolute, "linear files hold cd/m²");
  command->add_option("--contrast", display.contrast, "of the display, for integer pictures")
      ->capture_default_str();
  command->add_option("--gamma", display.gamma, "of the display")->capture_default_str();
  command->add_option("--ambient-lux", display.ambient_lux, "on the display")
      ->capture_default_str();
  command->add_option("--reflectivity", display.reflectivity, "of the display")
      ->capture_default_str();
  command->add_option("--out", a->out, "folders: keep each score here, and do not repeat it");
  command->add_option("--shard", a->shard, "i/N: only every Nth pair, from the ith on");
  command->add_flag("--json", a->as_json, "the result as JSON on standard output");
  command->footer(
      "Example:\n  wheatstone metric --test out/card/eye/left_displays.exr --reference "
      "out/card/eye/left_box.exr --metric hdr-vdp3 --ppd 45 --map out/visible.png");
  add_pu21(*command);
  command->callback([=] {
    if (command->get_subcommands().empty()) run_metric(*command, *a);
  });
}

}  // namespace wheatstone::apps
