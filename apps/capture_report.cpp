#include "apps/capture_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

#include "apps/capture_figures.h"
#include "apps/capture_statistics.h"
#include "apps/capture_verdict.h"
#include "apps/plot.h"
#include "apps/report.h"
#include "core/error.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/journal.h"
#include "core/json.h"
#include "core/png.h"
#include "core/text.h"
#include "rendering/metrics/false_colour.h"

namespace wheatstone::apps {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kThumbnailPx = 360;
constexpr std::size_t kMostThumbnails = 24;

cv::Mat3b thumbnail(const cv::Mat3b& picture) {
  const double scale = std::min(1.0, static_cast<double>(kThumbnailPx) / picture.cols);
  cv::Mat3b small;
  cv::resize(picture, small, {}, scale, scale, cv::INTER_AREA);
  return small;
}

/// Neither in the false colours nor, nearly, in the box.
const cv::Vec3b kSaturatedColour(0, 255, 255);

/// The picture, which may have a legend below, with what is saturated in a colour of its own.
cv::Mat3b marked(cv::Mat3b picture, const cv::Mat1b& saturated) {
  picture.rowRange(0, saturated.rows).setTo(kSaturatedColour, saturated);
  return picture;
}

/// The luminance that a share of the pixels does not exceed.
double quantile(std::vector<float> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// What is wrong, and what to do about it and next.
void verdict(Report& page, const Dataset& dataset, const std::vector<CapturedView>& views,
             const std::vector<CaptureProblem>& problems) {
  page.heading("Verdict");
  std::vector<std::string> lines;
  std::vector<Report::Step> steps;
  for (const CaptureProblem& p : problems) {
    lines.push_back(p.what);
    if (!p.remedy.empty()) steps.push_back({p.remedy, p.command});
  }
  if (problems.empty())
    page.verdict(true, "Nothing is wrong with what has been made so far.");
  else
    page.verdict(false, counted(problems.size(), "problem"), lines);

  page.heading("What to do");
  const std::string root = dataset.root().string();
  const bool merged = std::any_of(views.begin(), views.end(), [&](const CapturedView& v) {
    return fs::exists(dataset.file("hdr/" + v.name + ".exr"));
  });
  const bool posed = fs::exists(dataset.file("pose_report.json"));
  if (!merged) steps.push_back({"Merge the exposures of every view.", "wheatstone merge " + root});
  if (!posed)
    steps.push_back({"Find where the camera stood.", "wheatstone calibrate poses " + root});
  if (!merged || !posed)
    steps.push_back({"Make this page again, which then shows them.", "wheatstone report " + root});
  else if (!fs::exists(dataset.file("eyes.json")))
    steps.push_back(
        {"The poses are there. Find the observer's eyes.", "wheatstone calibrate eyes " + root});
  else
    steps.push_back(
        {"Eyes and poses are there. Render, then present.", "wheatstone render " + root});
  page.steps(steps);
}

void session(Report& page, const Dataset& dataset, const DatasetManifest& manifest) {
  page.heading("The session");
  const fs::path file = dataset.file("session/journal.jsonl");
  if (!fs::exists(file)) {
    page.paragraph("There is no journal: this folder was not captured by a session.");
    return;
  }
  std::map<std::string, int> count;
  std::vector<std::vector<std::string>> disturbances;
  json setup, returned;
  std::string first, last;
  for (const json& r : Journal::read(file)) {
    const std::string event = r.value("event", "");
    ++count[event];
    last = r.value("utc", "");
    if (first.empty()) first = last;
    if (event == "session") setup = r;
    if (event == "returned") returned = r;
    if (event == "stopped") disturbances.push_back({last, "stopped", r.value("why", "")});
    if (event == "set aside")
      disturbances.push_back({last, "set aside", r.value("file", "") + ": " + r.value("why", "")});
  }
  const json plan = setup.value("plan", json::object());
  std::string exposures;
  for (const double t : plan.value("exposures_s", std::vector<double>()))
    exposures += (exposures.empty() ? "" : ", ") + exposure_name(t);
  page.facts({{"rig", manifest.source},
              {"scene", manifest.scene},
              {"began", first},
              {"ended", last},
              {"views", fmt::format("{}", plan.value("views", 0))},
              {"exposures", exposures},
              {"frames recorded", fmt::format("{}", count["frame"])},
              {"resumed", counted(count["resumed"], "time")}});
  if (disturbances.empty())
    page.paragraph("Nothing disturbed it.");
  else
    page.table({"when (UTC)", "what", "why"}, disturbances, Report::Cells::kWords);
  if (returned.contains("seen_mm"))
    page.paragraph(
        fmt::format("Back at the first position, reached from the other side: {:+.3f} mm by the "
                    "encoder, {:+.3f} "
                    "mm as the markers show. A difference above 0.1 mm is backlash or lost steps.",
                    returned.value("encoder_mm", 0.0), returned.value("seen_mm", 0.0)));
  else if (returned.contains("problem"))
    page.paragraph("The return could not be checked: " + returned.value("problem", ""));
}

/// All views on one scale; returns the luminances of all of them, thinned out.
std::vector<float> thumbnails(Report& page, const Dataset& dataset,
                              const std::vector<CapturedView>& views) {
  page.heading("The views");
  std::vector<float> light;
  struct Merged {
    const CapturedView* view;
    RgbImage image;
    cv::Mat1b saturated;
  };
  std::vector<Merged> shown;
  std::size_t merged = 0;
  for (const CapturedView& view : views) {
    const fs::path file = dataset.file("hdr/" + view.name + ".exr");
    if (!fs::exists(file)) continue;
    ++merged;
    const RgbImage image = read_exr(file);
    const ScalarImage y = luminance_cd_m2(image);
    for (int r = 0; r < y.height(); r += 4)
      for (int c = 0; c < y.width(); c += 4) light.push_back(y.pixels(r, c));
    if (shown.size() < kMostThumbnails)
      shown.push_back({&view, image, merged_trust(file).saturated});
  }
  if (merged == 0) {
    page.paragraph("Not merged yet.");
    return light;
  }
  const double white = std::max(quantile(light, 0.995), 1e-3);
  page.paragraph(fmt::format(
      "{} of {} {} merged{}. White is {:.4g} cd/m² in every picture, which 99.5 % of all pixels do "
      "not exceed. Cyan is saturated even in the shortest exposure. Ranges are of 0.1 to 99.9 % of "
      "a view's pixels.",
      merged, counted(views.size(), "view"), views.size() == 1 ? "is" : "are",
      merged > shown.size() ? fmt::format(", the first {} are shown", shown.size()) : "", white));
  std::vector<Report::Picture> row;
  for (const auto& [view, image, saturated] : shown) {
    std::vector<float> y;
    const ScalarImage luminance = luminance_cd_m2(image);
    for (const float v : luminance.pixels) y.push_back(v);
    row.push_back(
        {thumbnail(marked(to_srgb8(image, white), saturated)),
         fmt::format("{} at {:.2f} mm: {:.3g} to {:.4g} cd/m², median {:.3g}", view->name,
                     view->reached_mm, quantile(y, 0.001), quantile(y, 0.999), quantile(y, 0.5))});
  }
  page.pictures(row);
  return light;
}

void exposure_ladder(Report& page, const CameraProfile& camera,
                     const std::vector<ExposureRecord>& exposures,
                     const std::vector<float>& light) {
  page.heading("Exposure ladder");
  page.plot(svg_of(exposure_ladder_figure(camera, exposures, light), 2),
            std::string("Left: from the light whose signal is twice its noise to saturation, green "
                        "photosites. Right: ") +
                (light.empty() ? "the light of all views, once they are merged."
                               : "the merged light of all views."));
}

std::string percent(double share) {
  return share == 0 ? "0" : share < 1e-4 ? "< 0.01" : fmt::format("{:.2f}", 100 * share);
}

/// Of one exposure: the median view's share and the worst one's, with its name.
std::vector<std::string> median_and_worst(const std::vector<ViewStatistics>& views,
                                          std::size_t exposure, double FrameStatistics::*share) {
  std::vector<std::pair<double, std::string>> shares;
  for (const ViewStatistics& view : views)
    if (exposure < view.frames.size()) shares.emplace_back(view.frames[exposure].*share, view.name);
  std::stable_sort(shares.begin(), shares.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  const auto& [worst, name] = shares.back();
  return {percent(shares[shares.size() / 2].first), percent(worst), worst > 0 ? name : "none"};
}

void clipping(Report& page, const CameraProfile& camera, const std::vector<CapturedView>& views,
              const std::vector<ViewStatistics>& statistics) {
  page.heading("Raw codes and clipping");
  std::vector<std::vector<std::string>> rows;
  const std::vector<ExposureRecord>& exposures = views.front().exposures;
  for (std::size_t e = 0; e < exposures.size(); ++e) {
    rows.push_back({exposure_name(exposures[e].exposure_s)});
    for (const auto share : {&FrameStatistics::saturated, &FrameStatistics::in_the_noise})
      for (const std::string& cell : median_and_worst(statistics, e, share))
        rows.back().push_back(cell);
  }
  page.table({"exposure", "saturated, median view (%)", "worst view (%)", "which",
              "in the noise, median view (%)", "worst view (%)", "which"},
             rows);
  page.plot(svg_of(clipping_figure(views, statistics), 2),
            "Saturated: the code is that of full light. In the noise: the signal is below twice "
            "its standard deviation by the camera's noise model.");
  const std::size_t middle = views.size() / 2;
  page.plot(svg_of({codes_figure(camera, views[middle], statistics[middle])}),
            "How often each code occurs in the middle view.");
}

void noise(Report& page, const std::vector<ViewStatistics>& views) {
  page.heading("Noise against the model");
  const ViewStatistics& middle = views[views.size() / 2];
  if (middle.noise.size() < 2) {
    page.paragraph(
        "One exposure, or too few photosites that two exposures measure: nothing to compare.");
    return;
  }
  page.plot(svg_of({noise_figure(middle)}),
            "Photosites that are unsaturated in two neighbouring exposures: the spread of the "
            "difference of their two measurements of the same light, over the one that the noise "
            "model predicts, with 95 % intervals. Above 1 the camera is noisier than its profile "
            "says, or the light or the exposure times differ from what is recorded. Signals of a "
            "few DN scatter more than their intervals say, because codes are whole numbers.");
}

void deviations(Report& page, const Dataset& dataset, const std::vector<CapturedView>& views) {
  page.heading("Uncertainty of the merged light");
  const std::string name = views[views.size() / 2].name;
  const fs::path file = dataset.file("hdr/" + name + ".exr");
  if (!fs::exists(file)) {
    page.paragraph("Not merged yet.");
    return;
  }
  const MergedTrust trust = merged_trust(file);
  if (trust.deviation_percent.empty()) {
    page.paragraph("The merged files have no deviations: the camera's noise was not known.");
    return;
  }
  page.pictures(
      {{thumbnail(marked(false_colour_difference(trust.deviation_percent, 10, "percent"),
                         trust.saturated)),
        name + ": standard deviation of the luminance of each cell of four photosites, in "
               "percent of its light; cyan is saturated"}});
}

void poses(Report& page, const Dataset& dataset) {
  page.heading("Poses and rail");
  const fs::path file = dataset.file("pose_report.json");
  if (!fs::exists(file)) {
    page.paragraph("Not calibrated yet.");
    return;
  }
  const json report = read_json(file, "wheatstone-pose-report/1");
  std::vector<std::vector<std::string>> rows;
  std::vector<Eigen::Vector2d> residuals;
  for (const json& view : report.at("views")) {
    const Eigen::Matrix<double, 6, 1> sigma = [&] {
      Eigen::Matrix<double, 6, 1> s;
      for (int i = 0; i < 6; ++i)
        s[i] = std::sqrt(view.at("covariance_rad_mm")
                             .at(static_cast<std::size_t>(i))
                             .at(static_cast<std::size_t>(i))
                             .get<double>());
      return s;
    }();
    rows.push_back({view.at("name").get<std::string>(),
                    fmt::format("{:.3f}", view.at("rms_px").get<double>()),
                    fmt::format("{:.3f}", view.at("near_plane_sigma_px").get<double>()),
                    fmt::format("{:.3f}", sigma.tail<3>().norm())});
    for (const json& r : view.value("residuals_px", json::array()))
      residuals.emplace_back(r.at(0).get<double>(), r.at(1).get<double>());
  }
  page.paragraph(fmt::format("Reprojection of the markers: {:.3f} px RMS over all views.",
                             report.at("rms_px").get<double>()));
  if (!residuals.empty())
    page.residual_plot(residuals,
                       "Residuals of the markers in the marker frames, predicted minus seen");
  page.table({"view", "reprojection RMS (px)", "uncertainty on the near plane (px)",
              "uncertainty of the place (mm)"},
             rows);
  if (fs::exists(dataset.file("rail.svg")))
    page.plot(
        read_text(dataset.file("rail.svg")),
        "Where each view stands, from its own markers alone, against a straight rail and even "
        "steps (the rail's scale taken out).");
}

}  // namespace

void write_capture_report(const Dataset& dataset, const fs::path& page_file) {
  const DatasetManifest manifest = dataset.read_manifest();
  if (manifest.kind != "capture")
    throw FileError(dataset.file("dataset.json"), "is no capture but of kind " + manifest.kind,
                    "name a folder that `wheatstone capture` has finished");
  const CameraProfile camera = dataset.read_camera();
  const std::vector<CapturedView> views = dataset.read_frames();
  if (views.empty() || views.front().exposures.empty())
    throw FileError(dataset.file("frames.json"), "names no frames", "capture again");
  std::vector<ViewStatistics> statistics;
  for (const CapturedView& view : views)
    statistics.push_back(view_statistics(dataset, view, camera));
  Report page("Capture " + dataset.root().filename().string());
  verdict(page, dataset, views, capture_problems(dataset, views, statistics));
  session(page, dataset, manifest);
  const std::vector<float> light = thumbnails(page, dataset, views);
  exposure_ladder(page, camera, views.front().exposures, light);
  clipping(page, camera, views, statistics);
  noise(page, statistics);
  deviations(page, dataset, views);
  poses(page, dataset);
  page.write(page_file);
}

}  // namespace wheatstone::apps
