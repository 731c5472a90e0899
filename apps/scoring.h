#pragma once
// Scoring pairs of pictures, one or a folder of them, with any of the program's metrics.

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/light_input.h"

namespace wheatstone::apps {

/// What to compute. Names are those of the command line.
struct ScoreOptions {
  std::string metric;    // pu21-psnr, pu21-ssim, ms-ssim, hdr-vdp3
  std::string channels;  // rgb or y; "" takes the metric's own: rgb for pu21-psnr, else y
  std::optional<double> pixels_per_degree;    // hdr-vdp3 only, which needs it
  std::optional<cv::Rect> region;             // crops both pictures and the mask
  std::optional<std::filesystem::path> mask;  // not for hdr-vdp3
  LightOptions light;

  /// The options as JSON, with defaults filled in: what makes two scores comparable.
  /// Errors: ArgumentError for an unknown metric, and for an option that the metric does not use.
  nlohmann::json settings() const;
};

struct Score {
  double value = 0;        // dB, similarity up to 1, or JOD; see unit_of()
  nlohmann::json details;  // hdr-vdp3: Q_JOD, Q, Q_err, P_det, C_max
  ScalarImage map;         // if asked for
};

/// Errors: ArgumentError and FileError of settings(), the readers and the metric; the files' names
/// stand before what a metric says of its two images.
Score score_pair(const std::filesystem::path& test, const std::filesystem::path& reference,
                 const ScoreOptions&, bool with_map = false);

/// Writes a score's map: .exr holds it as one channel; .png in false colour, for people.
/// Errors: ArgumentError for another extension; FileError.
void write_map(const std::filesystem::path&, const Score&, const std::string& metric);

struct Pair {
  std::string name;
  std::filesystem::path test, reference;
};
/// Pictures of the same name (without extension) in two folders, by name.
/// Errors: FileError naming a picture without partner, or two of one name; no picture at all.
std::vector<Pair> pairs_in(const std::filesystem::path& test,
                           const std::filesystem::path& reference);

/// Items k of a list with k % count == index - 1.
struct Shard {
  int index = 1, count = 1;
};
Shard shard_from_string(const std::string&);  // "2/8"; throws ArgumentError

struct NamedScore {
  std::string name;
  double value = 0;
};
/// Scores the shard's pairs. With `results`, each score is a file results/<name>.json, written
/// atomically as soon as it is there; a pair whose file has the same settings is not scored again.
/// Errors: as score_pair; FileError for a result made with other settings.
std::vector<NamedScore> score_folder(const std::vector<Pair>&, const ScoreOptions&, Shard,
                                     const std::optional<std::filesystem::path>& results,
                                     const std::function<void(int done, int total)>& progress);

struct Summary {
  int finite = 0, identical = 0;             // pairs; identical ones score +infinity
  std::optional<double> mean;                // over the finite ones, if any
  std::optional<double> standard_deviation;  // of the sample (n - 1), from two finite ones on
};
Summary summarise(const std::vector<NamedScore>&);

/// A number as JSON can hold it: infinity becomes the string "inf".
nlohmann::json json_number(double);

std::string unit_of(const std::string& metric);  // "dB", "" or "JOD"

}  // namespace wheatstone::apps
