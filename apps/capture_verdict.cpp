#include "apps/capture_verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "capture/merged_record.h"
#include "core/journal.h"
#include "core/json.h"

namespace wheatstone::apps {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kMostBadPixels = 0.01;     // of a view
constexpr double kMostNoise = 1.5;          // measured over model
constexpr double kMostReturnErrorMm = 0.1;  // seen against the encoder's

/// "view_003, view_004", the first few of them.
std::string some(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 5;
  std::string out;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i)
    out += (i == 0 ? "" : ", ") + names[i];
  return names.size() > kMost ? fmt::format("{} and {} more", out, names.size() - kMost) : out;
}

/// The worst view's share of pixels that no exposure measures, if it is too much.
void add_unmeasured(const std::vector<CapturedView>& views,
                    const std::vector<ViewStatistics>& statistics,
                    std::vector<CaptureProblem>& problems) {
  double saturated = 0, dark = 0;
  std::string brightest, darkest;
  for (std::size_t v = 0; v < statistics.size(); ++v) {
    const auto& exposures = views[v].exposures;
    if (exposures.empty()) continue;
    const auto [shortest, longest] = std::minmax_element(
        exposures.begin(), exposures.end(), [](const ExposureRecord& a, const ExposureRecord& b) {
          return a.exposure_s < b.exposure_s;
        });
    const auto frame = [&](auto e) {
      return statistics[v].frames[static_cast<std::size_t>(e - exposures.begin())];
    };
    if (const double share = frame(shortest).saturated; share > saturated) {
      saturated = share;
      brightest = views[v].name;
    }
    if (const double share = frame(longest).in_the_noise; share > dark) {
      dark = share;
      darkest = views[v].name;
    }
  }
  if (saturated > kMostBadPixels)
    problems.push_back(
        {fmt::format("{:.3g} % of the pixels of {} are saturated in the shortest exposure: their "
                     "light is a lower bound.",
                     100 * saturated, brightest),
         "Capture with a shorter exposure."});
  if (dark > kMostBadPixels)
    problems.push_back({fmt::format("{:.3g} % of {} are in the noise of the longest exposure.",
                                    100 * dark, darkest),
                        "Capture with a longer exposure."});
}

void add_noise(const std::vector<ViewStatistics>& statistics,
               std::vector<CaptureProblem>& problems) {
  std::vector<double> ratios;
  for (const ViewStatistics& view : statistics)
    for (const NoiseLevel& level : view.noise) ratios.push_back(level.measured_over_model);
  if (ratios.empty()) return;
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  if (*middle > kMostNoise)
    problems.push_back(
        {fmt::format("The exposures of a view differ by {:.3g} times the noise of the camera's "
                     "profile.",
                     *middle),
         "Check the profile, the exposure times, and whether the light was steady."});
}

void add_merges(const Dataset& dataset, const std::vector<CapturedView>& views,
                std::vector<CaptureProblem>& problems) {
  std::vector<std::string> missing, damaged;
  for (const CapturedView& view : views) {
    const fs::path exr = dataset.file("hdr/" + view.name + ".exr");
    const auto record = read_merged_record(dataset.file("hdr/" + view.name + ".json"));
    if (!fs::exists(exr))
      missing.push_back(view.name);
    else if (!record || !holds_what_was_written(*record, exr))
      damaged.push_back(view.name);
  }
  const std::string merge = "wheatstone merge " + dataset.root().string();
  if (!missing.empty() && missing.size() < views.size())
    problems.push_back({some(missing) + ": not merged.", "Merge what is missing.", merge});
  if (!damaged.empty())
    problems.push_back({some(damaged) + ": the HDR file is not what its record says.",
                        "Merge what is damaged again.", merge});
}

void add_return(const Dataset& dataset, std::vector<CaptureProblem>& problems) {
  const fs::path file = dataset.file("session/journal.jsonl");
  if (!fs::exists(file)) return;
  json returned = json::object();
  for (const json& r : Journal::read(file))
    if (r.value("event", "") == "returned") returned = r;
  if (returned.contains("problem"))
    problems.push_back(
        {"The return to the first position could not be checked: " + returned.value("problem", ""),
         "See to the markers and capture again, unless the rail is known to keep its place."});
  const double error_mm = returned.value("seen_mm", 0.0) - returned.value("encoder_mm", 0.0);
  if (returned.contains("seen_mm") && std::abs(error_mm) > kMostReturnErrorMm)
    problems.push_back(
        {fmt::format("The carriage came back {:+.3f} mm beside where its encoder says: backlash or "
                     "lost steps.",
                     error_mm),
         "Check the belt, the motor's current and the speed, and capture again."});
}

void add_poses(const Dataset& dataset, std::vector<CaptureProblem>& problems) {
  const fs::path file = dataset.file("pose_report.json");
  if (!fs::exists(file)) return;
  std::vector<std::string> bad;
  for (const json& view :
       read_json(file, "wheatstone-pose-report/1").value("bad_views", json::array()))
    bad.push_back(view.value("name", ""));
  if (!bad.empty())
    problems.push_back({some(bad) + ": left out of the poses, because the markers contradict.",
                        "See the reasons under bad_views in pose_report.json."});
}

}  // namespace

std::vector<CaptureProblem> capture_problems(const Dataset& dataset,
                                             const std::vector<CapturedView>& views,
                                             const std::vector<ViewStatistics>& statistics) {
  std::vector<CaptureProblem> problems;
  add_unmeasured(views, statistics, problems);
  add_noise(statistics, problems);
  add_return(dataset, problems);
  add_merges(dataset, views, problems);
  add_poses(dataset, problems);
  return problems;
}

}  // namespace wheatstone::apps
