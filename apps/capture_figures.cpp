#include "apps/capture_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace wheatstone::apps {
namespace {

/// Ticks of a logarithmic axis.
std::vector<double> decades(double lowest, double highest) {
  std::vector<double> out;
  for (double d = std::floor(std::log10(lowest)); d <= std::ceil(std::log10(highest)); ++d)
    out.push_back(std::pow(10.0, d));
  return out;
}

Plot histogram_of(const std::vector<float>& light_cd_m2, const PlotAxis& x, double lowest,
                  double highest) {
  const double half_stop = std::sqrt(2.0);
  std::vector<double> centres, shares;
  for (double at = lowest; at < highest; at *= half_stop) {
    const auto n = std::count_if(light_cd_m2.begin(), light_cd_m2.end(),
                                 [&](float v) { return v >= at && v < at * half_stop; });
    centres.push_back(at * std::sqrt(half_stop));
    shares.push_back(100.0 * static_cast<double>(n) / static_cast<double>(light_cd_m2.size()));
  }
  Plot plot("What there is", x, {"pixels per half stop (%)"});
  plot.line("all views", centres, shares);
  plot.hide_legend();
  return plot;
}

Plot shares_along_the_rail(const std::string& title, const std::vector<CapturedView>& views,
                           const std::vector<ViewStatistics>& statistics,
                           double FrameStatistics::*share) {
  struct Line {
    std::string name;
    std::vector<double> x, y;
  };
  std::vector<Line> lines;
  double highest = 0;
  for (std::size_t v = 0; v < views.size(); ++v)
    for (std::size_t e = 0; e < views[v].exposures.size(); ++e) {
      if (e == lines.size())
        lines.push_back({exposure_name(views[v].exposures[e].exposure_s), {}, {}});
      lines[e].x.push_back(views[v].reached_mm);
      lines[e].y.push_back(100 * statistics[v].frames[e].*share);
      highest = std::max(highest, lines[e].y.back());
    }
  Plot plot(title, {"position on the rail (mm)"},
            {"photosites (%)", false, {{0, std::max(0.1, 1.1 * highest)}}});
  for (const Line& l : lines) {
    plot.line(l.name, l.x, l.y);
    plot.points(l.name, l.x, l.y);
  }
  return plot;
}

}  // namespace

std::string exposure_name(double s) {
  return s < 0.4 ? fmt::format("1/{:.4g} s", 1 / s) : fmt::format("{:.4g} s", s);
}

std::vector<Plot> exposure_ladder_figure(const CameraProfile& camera,
                                         const std::vector<ExposureRecord>& exposures,
                                         const std::vector<float>& light_cd_m2) {
  const double green_per_cd_m2 = camera.camera_from_bt709.row(1).sum() * camera.dn_per_cd_m2_s;
  const double least_dn = least_signal_dn(camera), most_dn = camera.white_dn - camera.black_dn;
  const auto [shortest, longest] = std::minmax_element(
      exposures.begin(), exposures.end(),
      [](const ExposureRecord& a, const ExposureRecord& b) { return a.exposure_s < b.exposure_s; });
  const double lowest = least_dn / (green_per_cd_m2 * longest->exposure_s);
  const double highest = most_dn / (green_per_cd_m2 * shortest->exposure_s);
  const PlotAxis x = {"luminance of white light (cd/m²)",
                      true,
                      {{lowest / 2, highest * 2}},
                      decades(lowest, highest)};
  Plot ladder("What each exposure measures", x,
              {"exposure time (s)",
               true,
               {{shortest->exposure_s / 2, longest->exposure_s * 2}},
               decades(shortest->exposure_s, longest->exposure_s)});
  for (const ExposureRecord& e : exposures)
    ladder.line(
        exposure_name(e.exposure_s),
        {least_dn / (green_per_cd_m2 * e.exposure_s), most_dn / (green_per_cd_m2 * e.exposure_s)},
        {e.exposure_s, e.exposure_s});
  std::vector<Plot> panels = {ladder};
  if (!light_cd_m2.empty()) panels.push_back(histogram_of(light_cd_m2, x, lowest / 2, highest * 2));
  return panels;
}

std::vector<Plot> clipping_figure(const std::vector<CapturedView>& views,
                                  const std::vector<ViewStatistics>& statistics) {
  return {shares_along_the_rail("Saturated", views, statistics, &FrameStatistics::saturated),
          shares_along_the_rail("In the noise", views, statistics, &FrameStatistics::in_the_noise)};
}

Plot codes_figure(const CameraProfile& camera, const CapturedView& view,
                  const ViewStatistics& statistics) {
  const double full = camera.white_dn - camera.black_dn;
  const double tick = std::max(1.0, std::pow(2.0, std::floor(std::log2(full / 3))));
  std::vector<double> ticks;
  for (double t = 0; t <= full; t += tick) ticks.push_back(t);
  Plot plot("Raw codes of " + view.name, {"code above black (DN)", false, {{0, full}}, ticks},
            {"photosites (%)", true, {{1e-3, 100}}, decades(1e-3, 100)});
  for (std::size_t i = 0; i < statistics.frames.size(); ++i) {
    const FrameStatistics& frame = statistics.frames[i];
    std::vector<double> x, y;
    for (std::size_t bin = 0; bin < frame.histogram.size(); ++bin) {
      if (frame.histogram[bin] <= 1e-5) continue;
      x.push_back((static_cast<double>(bin) + 0.5) * frame.bin_dn);
      y.push_back(100 * frame.histogram[bin]);
    }
    if (!x.empty()) plot.line(exposure_name(view.exposures[i].exposure_s), x, y);
  }
  return plot;
}

Plot noise_figure(const ViewStatistics& view) {
  if (view.noise.size() < 2)
    throw ArgumentError(view.name + " has too few levels of noise for a plot",
                        "capture more exposures");
  std::vector<double> x, y, low, high;
  for (const NoiseLevel& level : view.noise) {
    x.push_back(level.signal_dn);
    y.push_back(level.measured_over_model);
    low.push_back(level.measured_over_model - 2 * level.sigma);
    high.push_back(level.measured_over_model + 2 * level.sigma);
  }
  Plot plot("Noise of " + view.name,
            {"signal of the longer exposure (DN)", true, {}, decades(x.front(), x.back())},
            {"measured / model"});
  plot.points("measured", x, y, low, high);
  plot.line("model", {x.front(), x.back()}, {1, 1});
  return plot;
}

}  // namespace wheatstone::apps
