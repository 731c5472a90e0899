#include "apps/scoring.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>

#include "core/error.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/json.h"
#include "core/png.h"
#include "rendering/metrics/false_colour.h"
#include "rendering/metrics/hdrvdp3.h"
#include "rendering/metrics/pu21.h"
#include "rendering/metrics/ssim.h"

namespace wheatstone::apps {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kScoreSchema = "wheatstone-score/1";

struct MetricFacts {
  const char *name, *unit, *default_channels;
  const char* map_channel;  // of an EXR map; null if the metric has no map
};
constexpr MetricFacts kMetrics[] = {{"pu21-psnr", "dB", "rgb", "pu21_difference"},
                                    {"pu21-ssim", "", "y", "ssim"},
                                    {"ms-ssim", "", "y", nullptr},
                                    {"hdr-vdp3", "JOD", "rgb", "p_det"}};

const MetricFacts& facts_of(const std::string& metric) {
  for (const MetricFacts& m : kMetrics)
    if (metric == m.name) return m;
  throw ArgumentError("'" + metric + "' is no metric",
                      "use pu21-psnr, pu21-ssim, ms-ssim or hdr-vdp3");
}

double number_from_json(const json& value, const fs::path& file) {
  if (value == "inf") return std::numeric_limits<double>::infinity();
  if (!value.is_number()) throw FileError(file, "has no number as \"value\"", "delete it");
  return value;
}

void require_region(const cv::Rect& region, cv::Size size) {
  if (region.width < 1 || region.height < 1 || (region & cv::Rect({0, 0}, size)) != region)
    throw ArgumentError(
        fmt::format("the region {},{},{},{} is not within the {}x{} pixels", region.x, region.y,
                    region.width, region.height, size.width, size.height),
        "give x,y,width,height inside the pictures");
}

void crop(RgbImage& image, const std::optional<cv::Rect>& region) {
  if (!region) return;
  require_region(*region, image.pixels.size());
  image.pixels = image.pixels(*region).clone();
}

Score hdr_vdp3_score(const RgbImage& test, const RgbImage& reference, const ScoreOptions& options) {
  HdrVdp3Result r = hdr_vdp3(test, reference, {.pixels_per_degree = *options.pixels_per_degree});
  return {
      r.q_jod,
      {{"Q_JOD", r.q_jod}, {"Q", r.q}, {"Q_err", r.q_err}, {"P_det", r.p_det}, {"C_max", r.c_max}},
      std::move(r.detection_probability)};
}

Score score_images(const RgbImage& test, const RgbImage& reference, const cv::Mat1b* mask,
                   const ScoreOptions& options, bool rgb, bool with_map) {
  Score out;
  ScalarImage* map = with_map ? &out.map : nullptr;
  if (options.metric == "pu21-psnr") {
    out.value =
        rgb ? pu21_psnr_rgb(test, reference, mask) : pu21_psnr_luminance(test, reference, mask);
    if (map) *map = pu21_difference(test, reference);
  } else if (options.metric == "pu21-ssim") {
    out.value = rgb ? pu21_ssim_rgb(test, reference, mask, map)
                    : pu21_ssim_luminance(test, reference, mask, map);
  } else if (options.metric == "ms-ssim") {
    out.value = rgb ? pu21_ms_ssim_rgb(test, reference, mask)
                    : pu21_ms_ssim_luminance(test, reference, mask);
  } else {
    out = hdr_vdp3_score(test, reference, options);
  }
  return out;
}

}  // namespace

std::string unit_of(const std::string& metric) {
  return facts_of(metric).unit;
}

json ScoreOptions::settings() const {
  const MetricFacts& facts = facts_of(metric);
  const bool is_vdp = metric == "hdr-vdp3";
  if (!channels.empty() && channels != "rgb" && channels != "y")
    throw ArgumentError("'" + channels + "' are no channels", "use rgb or y");
  if (is_vdp && channels == "y")
    throw ArgumentError("hdr-vdp3 takes colour pictures", "leave out --channel");
  if (is_vdp && mask)
    throw ArgumentError("hdr-vdp3 has no mask", "leave out --mask, or crop with --roi");
  if (is_vdp && !pixels_per_degree)
    throw ArgumentError("hdr-vdp3 needs the pixels per degree of visual angle",
                        "give --ppd, or --pixel-pitch-mm and --distance-mm");
  if (!is_vdp && pixels_per_degree)
    throw ArgumentError(metric + " does not depend on the pixels per degree",
                        "leave out --ppd, or use hdr-vdp3");
  json out = {{"metric", metric},
              {"channels", channels.empty() ? facts.default_channels : channels}};
  if (pixels_per_degree) out["pixels_per_degree"] = *pixels_per_degree;
  if (region) out["region"] = {region->x, region->y, region->width, region->height};
  if (mask) out["mask"] = mask->string();
  out["absolute"] = light.absolute;
  if (light.peak_cd_m2) {
    out["peak_cd_m2"] = *light.peak_cd_m2;
    out["display"] = {{"contrast", light.display.contrast},
                      {"gamma", light.display.gamma},
                      {"ambient_lux", light.display.ambient_lux},
                      {"reflectivity", light.display.reflectivity}};
  }
  return out;
}

Score score_pair(const fs::path& test_file, const fs::path& reference_file,
                 const ScoreOptions& options, bool with_map) {
  const bool rgb = options.settings()["channels"] == "rgb";
  RgbImage test = read_light(test_file, options.light);
  RgbImage reference = read_light(reference_file, options.light);
  std::optional<cv::Mat1b> mask;
  if (options.mask) mask = read_mask(*options.mask);
  try {
    if (mask && mask->size() == test.pixels.size() && options.region) {
      require_region(*options.region, mask->size());
      mask = (*mask)(*options.region).clone();
    }
    crop(test, options.region);
    crop(reference, options.region);
    return score_images(test, reference, mask ? &*mask : nullptr, options, rgb, with_map);
  } catch (const ArgumentError& e) {
    throw ArgumentError(
        fmt::format("{} against {}: {}", test_file.string(), reference_file.string(), e.what()),
        "");
  }
}

void write_map(const fs::path& path, const Score& score, const std::string& metric) {
  const MetricFacts& facts = facts_of(metric);
  if (!facts.map_channel)
    throw ArgumentError(metric + " has no map", "leave out --map, or use pu21-ssim");
  if (path.extension() == ".exr") return write_exr(path, score.map, facts.map_channel);
  if (path.extension() != ".png")
    throw ArgumentError(path.string() + " is neither .exr nor .png",
                        "end the map's name in one of these");
  if (metric == "pu21-psnr")
    write_picture_png(path, false_colour_difference(score.map, 50, "PU21 units"));
  else if (metric == "pu21-ssim")
    write_picture_png(
        path, false_colour_difference(ScalarImage(cv::Mat1f(1 - score.map.pixels)), 1, "1 - SSIM"));
  else
    write_picture_png(path, false_colour_difference(score.map, 1, "probability of detection"));
}

std::vector<Pair> pairs_in(const fs::path& test, const fs::path& reference) {
  const auto pictures = [](const fs::path& folder) {
    std::map<std::string, fs::path> out;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      if (!entry.is_regular_file() || !is_picture(entry.path())) continue;
      const auto [at, is_new] = out.emplace(entry.path().stem().string(), entry.path());
      if (!is_new)
        throw FileError(entry.path(), "has the same name as " + at->second.filename().string(),
                        "keep one picture of each name");
    }
    if (error) throw FileError(folder, "cannot be listed: " + error.message(), "check the path");
    if (out.empty()) throw FileError(folder, "holds no picture", "check the path");
    return out;
  };
  const auto tests = pictures(test), references = pictures(reference);
  std::vector<Pair> out;
  for (const auto& [name, file] : tests) {
    const auto partner = references.find(name);
    if (partner == references.end())
      throw FileError(file, "has no partner '" + name + "' in " + reference.string(),
                      "add it, or take this one away");
    out.push_back({name, file, partner->second});
  }
  for (const auto& [name, file] : references)
    if (!tests.count(name))
      throw FileError(file, "has no partner '" + name + "' in " + test.string(),
                      "add it, or take this one away");
  return out;
}

Shard shard_from_string(const std::string& text) {
  Shard out;
  const auto number = [&](std::size_t begin, std::size_t end, int& value) {
    const auto [parsed_to, error] = std::from_chars(text.data() + begin, text.data() + end, value);
    return error == std::errc() && parsed_to == text.data() + end;
  };
  const auto slash = text.find('/');
  if (slash == std::string::npos || !number(0, slash, out.index) ||
      !number(slash + 1, text.size(), out.count) || out.index < 1 || out.count < out.index)
    throw ArgumentError("'" + text + "' is no shard", "write i/N with 1 <= i <= N, such as 2/8");
  return out;
}

std::vector<NamedScore> score_folder(const std::vector<Pair>& pairs, const ScoreOptions& options,
                                     Shard shard, const std::optional<fs::path>& results,
                                     const std::function<void(int, int)>& progress) {
  const json settings = options.settings();
  std::vector<const Pair*> mine;
  for (std::size_t k = 0; k < pairs.size(); ++k)
    if (static_cast<int>(k % static_cast<std::size_t>(shard.count)) == shard.index - 1)
      mine.push_back(&pairs[k]);
  if (results) make_folder(*results);
  std::vector<NamedScore> out;
  for (const Pair* pair : mine) {
    const fs::path file = results ? *results / (pair->name + ".json") : fs::path();
    if (results && fs::exists(file)) {
      const json kept = read_json(file, kScoreSchema);
      if (kept.value("settings", json()) != settings)
        throw FileError(file, "was made with other settings", "choose another folder");
      out.push_back({pair->name, number_from_json(kept.value("value", json()), file)});
    } else {
      const Score score = score_pair(pair->test, pair->reference, options);
      if (results) {
        json document = score.details.is_null() ? json::object() : score.details;
        document["value"] = json_number(score.value);
        document["settings"] = settings;
        document["test"] = pair->test.filename().string();
        document["reference"] = pair->reference.filename().string();
        write_json(file, kScoreSchema, document);
      }
      out.push_back({pair->name, score.value});
    }
    progress(static_cast<int>(out.size()), static_cast<int>(mine.size()));
  }
  return out;
}

Summary summarise(const std::vector<NamedScore>& scores) {
  Summary out;
  double sum = 0;
  for (const NamedScore& s : scores) {
    std::isinf(s.value) ? ++out.identical : ++out.finite;
    if (std::isfinite(s.value)) sum += s.value;
  }
  if (out.finite == 0) return out;
  out.mean = sum / out.finite;
  if (out.finite == 1) return out;
  double squares = 0;
  for (const NamedScore& s : scores)
    if (std::isfinite(s.value)) squares += (s.value - *out.mean) * (s.value - *out.mean);
  out.standard_deviation = std::sqrt(squares / (out.finite - 1));
  return out;
}

json json_number(double value) {
  return std::isinf(value) ? json("inf") : json(value);
}

}  // namespace wheatstone::apps
