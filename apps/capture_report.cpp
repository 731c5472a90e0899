#include "apps/capture_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

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
#include "rendering/metrics/false_colour.h"

namespace wheatstone::apps {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kThumbnailPx = 360;
constexpr std::size_t kMostThumbnails = 24;

std::string exposure_name(double s) {
  return s < 0.4 ? fmt::format("1/{:.4g} s", 1 / s) : fmt::format("{:.4g} s", s);
}

/// Ticks of a logarithmic axis.
std::vector<double> decades(double lowest, double highest) {
  std::vector<double> out;
  for (double d = std::floor(std::log10(lowest)); d <= std::ceil(std::log10(highest)); ++d)
    out.push_back(std::pow(10.0, d));
  return out;
}

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

void verdict(Report& page, const std::vector<std::string>& problems) {
  page.heading("Verdict");
  if (problems.empty()) page.paragraph("Nothing is wrong with what has been made so far.");
  for (const std::string& problem : problems) page.paragraph(problem);
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
  page.table({"session", ""}, {{"rig", manifest.source},
                               {"scene", manifest.scene},
                               {"began, ended (UTC)", first + ", " + last},
                               {"views", fmt::format("{}", plan.value("views", 0))},
                               {"exposures", exposures},
                               {"frames recorded", fmt::format("{}", count["frame"])},
                               {"resumed", fmt::format("{} times", count["resumed"])}});
  if (disturbances.empty())
    page.paragraph("Nothing disturbed it.");
  else
    page.table({"when (UTC)", "what", "why"}, disturbances);
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
  std::vector<Merged> merged;
  for (const CapturedView& view : views) {
    const fs::path file = dataset.file("hdr/" + view.name + ".exr");
    if (!fs::exists(file)) continue;
    const RgbImage image = read_exr(file);
    const ScalarImage y = luminance_cd_m2(image);
    for (int r = 0; r < y.height(); r += 4)
      for (int c = 0; c < y.width(); c += 4) light.push_back(y.pixels(r, c));
    if (merged.size() < kMostThumbnails)
      merged.push_back({&view, image, merged_trust(file).saturated});
  }
  if (merged.empty()) {
    page.paragraph("Not merged yet: run wheatstone merge on this folder.");
    return light;
  }
  const double white = std::max(quantile(light, 0.995), 1e-3);
  page.paragraph(fmt::format(
      "{} of {} views are merged{}. White in the pictures is {:.4g} cd/m^2, which 99.5 % of all "
      "pixels do not exceed; the same in every picture. Cyan is saturated even in the shortest "
      "exposure.",
      light.empty() ? 0
                    : std::count_if(views.begin(), views.end(),
                                    [&](const CapturedView& v) {
                                      return fs::exists(dataset.file("hdr/" + v.name + ".exr"));
                                    }),
      views.size(),
      views.size() > kMostThumbnails ? fmt::format(", the first {} are shown", kMostThumbnails)
                                     : "",
      white));
  std::vector<Report::Picture> row;
  for (const auto& [view, image, saturated] : merged) {
    std::vector<float> y;
    const ScalarImage luminance = luminance_cd_m2(image);
    for (const float v : luminance.pixels) y.push_back(v);
    row.push_back(
        {thumbnail(marked(to_srgb8(image, white), saturated)),
         fmt::format(
             "{} at {:.2f} mm: {:.3g} to {:.4g} cd/m^2 (0.1 to 99.9 %), median {:.3g} cd/m^2",
             view->name, view->reached_mm, quantile(y, 0.001), quantile(y, 0.999),
             quantile(y, 0.5))});
  }
  page.pictures(row);
  return light;
}

/// Which light each exposure measures, above how much light there is.
void exposure_ladder(Report& page, const CameraProfile& camera,
                     const std::vector<ExposureRecord>& exposures,
                     const std::vector<float>& light) {
  page.heading("Exposure ladder");
  const double green_per_cd_m2 = camera.camera_from_bt709.row(1).sum() * camera.dn_per_cd_m2_s;
  double lowest = 1e9, highest = 0;
  std::vector<std::pair<double, double>> ends;
  for (const ExposureRecord& e : exposures) {
    const double least_dn = least_signal_dn(camera), most_dn = camera.white_dn - camera.black_dn;
    ends.emplace_back(least_dn / (green_per_cd_m2 * e.exposure_s),
                      most_dn / (green_per_cd_m2 * e.exposure_s));
    lowest = std::min(lowest, ends.back().first);
    highest = std::max(highest, ends.back().second);
  }
  const PlotAxis x = {"luminance of white light (cd/m^2)",
                      true,
                      {{lowest / 2, highest * 2}},
                      decades(lowest, highest)};
  std::vector<double> times;
  for (const ExposureRecord& e : exposures) times.push_back(e.exposure_s);
  const auto [shortest, longest] = std::minmax_element(times.begin(), times.end());
  Plot ladder(
      "What each exposure measures", x,
      {"exposure time (s)", true, {{*shortest / 2, *longest * 2}}, decades(*shortest, *longest)});
  for (std::size_t i = 0; i < exposures.size(); ++i)
    ladder.line(exposure_name(exposures[i].exposure_s), {ends[i].first, ends[i].second},
                {exposures[i].exposure_s, exposures[i].exposure_s});
  std::vector<Plot> panels = {ladder};
  if (!light.empty()) {
    std::vector<double> centres, shares;
    for (double at = lowest / 2; at < highest * 2; at *= std::sqrt(2.0)) {
      const auto n = std::count_if(light.begin(), light.end(),
                                   [at](float v) { return v >= at && v < at * std::sqrt(2.0); });
      centres.push_back(at * std::pow(2.0, 0.25));
      shares.push_back(100.0 * static_cast<double>(n) / static_cast<double>(light.size()));
    }
    Plot histogram("What there is", x, {"pixels per half stop (%)"});
    histogram.line("all views", centres, shares);
    histogram.hide_legend();
    panels.push_back(histogram);
  }
  page.plot(svg_of(panels, 2),
            "Left: from the light whose signal is twice its noise to saturation, green photosites. "
            "Right: the merged light of all views.");
}

std::string percent(double share) {
  return share == 0 ? "0" : share < 1e-4 ? "< 0.01 %" : fmt::format("{:.2f} %", 100 * share);
}

void clipping(Report& page, const CameraProfile& camera, const std::vector<ViewStatistics>& views,
              const std::vector<ExposureRecord>& exposures) {
  page.heading("Raw codes and clipping");
  std::vector<std::string> header = {"view"};
  for (const ExposureRecord& e : exposures) {
    header.push_back(exposure_name(e.exposure_s) + " saturated");
    header.push_back("in the noise");
  }
  std::vector<std::vector<std::string>> rows;
  for (const ViewStatistics& view : views) {
    rows.push_back({view.name});
    for (const FrameStatistics& frame : view.frames) {
      rows.back().push_back(percent(frame.saturated));
      rows.back().push_back(percent(frame.in_the_noise));
    }
  }
  page.table(header, rows);
  const ViewStatistics& middle = views[views.size() / 2];
  const double full = camera.white_dn - camera.black_dn;
  const double tick = std::max(1.0, std::pow(2.0, std::floor(std::log2(full / 3))));
  std::vector<double> ticks;
  for (double t = 0; t <= full; t += tick) ticks.push_back(t);
  Plot plot("Raw codes of " + middle.name, {"code above black (DN)", false, {{0, full}}, ticks},
            {"photosites (%)", true, {{1e-3, 100}}, decades(1e-3, 100)});
  for (std::size_t i = 0; i < middle.frames.size(); ++i) {
    std::vector<double> x, y;
    for (std::size_t bin = 0; bin < middle.frames[i].histogram.size(); ++bin) {
      if (middle.frames[i].histogram[bin] <= 1e-5) continue;
      x.push_back((static_cast<double>(bin) + 0.5) * middle.frames[i].bin_dn);
      y.push_back(100 * middle.frames[i].histogram[bin]);
    }
    if (!x.empty()) plot.line(exposure_name(exposures[i].exposure_s), x, y);
  }
  page.plot(
      svg_of({plot}),
      "Saturated: the code is that of full light. In the noise: the signal is below twice its "
      "standard deviation by the camera's noise model.");
}

void noise(Report& page, const std::vector<ViewStatistics>& views) {
  page.heading("Noise against the model");
  std::vector<double> x, y;
  const ViewStatistics& middle = views[views.size() / 2];
  for (const NoiseLevel& level : middle.noise) {
    x.push_back(level.signal_dn);
    y.push_back(level.measured_over_model);
  }
  if (x.size() < 2) {
    page.paragraph(
        "One exposure, or too few photosites that two exposures measure: nothing to compare.");
    return;
  }
  Plot plot("Noise of " + middle.name,
            {"signal of the longer exposure (DN)", true, {}, decades(x.front(), x.back())},
            {"measured / model"});
  plot.points("neighbouring exposures", x, y);
  plot.line("model", {x.front(), x.back()}, {1, 1});
  page.plot(
      svg_of({plot}),
      "Photosites that are unsaturated in two neighbouring exposures: the spread of the "
      "difference of their two measurements of the same light, over the one that the noise "
      "model predicts. Above 1 the camera is noisier than its profile says, or the light or the "
      "exposure times differ from what is recorded.");
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
    page.paragraph("Not calibrated yet: run wheatstone calibrate poses on this folder.");
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
    page.residual_plot(residuals, 0.1, "Residuals of the markers in the marker frames");
  page.table({"view", "reprojection RMS (px)", "uncertainty on the near plane (px)",
              "uncertainty of the place (mm)"},
             rows);
  if (fs::exists(dataset.file("rail.svg")))
    page.plot(
        read_text(dataset.file("rail.svg")),
        "Where each view stands, from its own markers alone, against a straight rail and even "
        "steps.");
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
  verdict(page, capture_problems(dataset, views, statistics));
  session(page, dataset, manifest);
  const std::vector<float> light = thumbnails(page, dataset, views);
  exposure_ladder(page, camera, views.front().exposures, light);
  clipping(page, camera, statistics, views.front().exposures);
  noise(page, statistics);
  deviations(page, dataset, views);
  poses(page, dataset);
  page.write(page_file);
}

}  // namespace wheatstone::apps
