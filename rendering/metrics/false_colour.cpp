#include "rendering/metrics/false_colour.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/error.h"

namespace wheatstone {
namespace {

/// The 256 colours of a map, R, G, B.
cv::Mat3b colours(cv::ColormapTypes map) {
  cv::Mat1b ramp(1, 256);
  for (int i = 0; i < 256; ++i) ramp(0, i) = static_cast<unsigned char>(i);
  cv::Mat3b out;
  cv::applyColorMap(ramp, out, map);
  cv::cvtColor(out, out, cv::COLOR_BGR2RGB);
  return out;
}

/// fraction(row, column), clamped to 0..1, as colours.
template <class Fraction>
cv::Mat3b painted(cv::Size size, const cv::Mat3b& map, Fraction fraction) {
  cv::Mat3b out(size);
  for (int r = 0; r < out.rows; ++r)
    for (int c = 0; c < out.cols; ++c)
      out(r, c) = map(0, static_cast<int>(std::lround(255 * std::clamp(fraction(r, c), 0.0, 1.0))));
  return out;
}

struct Tick {
  double fraction;                  // along the bar
  std::vector<std::string> labels;  // one for each line of text
};

/// Lettering that stays readable when a wide picture is shown small.
struct Lettering {
  double scale;  // of all lengths below; 1 up to 640 px of width
  int thickness;

  explicit Lettering(int width)
      : scale(std::max(1.0, width / 640.0)),
        thickness(std::max(1, static_cast<int>(std::lround(scale)))) {}

  int px(double at_640) const { return static_cast<int>(std::lround(at_640 * scale)); }
  int width(const std::string& text) const {
    return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, 0.38 * scale, thickness, nullptr).width;
  }
  void write(cv::Mat3b& on, const std::string& text, int x, int baseline) const {
    cv::putText(on, text, {x, baseline}, cv::FONT_HERSHEY_SIMPLEX, 0.38 * scale, {30, 30, 30},
                thickness, cv::LINE_AA);
  }
};

/// The picture with a bar of the map's colours below; `heads` name the lines of labels, `caption`
/// is a line of its own. Labels that would run into the one before are left out.
cv::Mat3b with_legend(const cv::Mat3b& picture, const cv::Mat3b& map,
                      const std::vector<std::string>& heads, const std::vector<Tick>& ticks,
                      const std::string& caption) {
  const Lettering lettering(picture.cols);
  const int line = lettering.px(15), bar = lettering.px(12), gap = lettering.px(5);
  int begin = 0;
  for (const std::string& head : heads) begin = std::max(begin, lettering.width(head));
  begin = std::min(begin + 2 * gap, picture.cols / 2);
  const int end = std::max(begin + 1, picture.cols - lettering.px(20));
  cv::Mat3b legend(2 * gap + bar + line * static_cast<int>(heads.size() + 1), picture.cols,
                   cv::Vec3b(255, 255, 255));
  for (int c = begin; c < end; ++c)
    legend.col(c).rowRange(gap, gap + bar) = cv::Scalar(map(0, 255 * (c - begin) / (end - begin)));
  const auto baseline = [&](std::size_t i) {
    return gap + bar + line * static_cast<int>(i + 1) - 2;
  };
  for (std::size_t i = 0; i < heads.size(); ++i)
    lettering.write(legend, heads[i], gap, baseline(i));
  int free_from = begin - gap;
  for (const Tick& tick : ticks) {
    const int at = begin + static_cast<int>(std::lround(tick.fraction * (end - begin - 1)));
    int widest = 0;
    for (const std::string& label : tick.labels) widest = std::max(widest, lettering.width(label));
    if (at - widest / 2 < free_from || at + widest / 2 >= legend.cols) continue;
    free_from = at + widest / 2 + gap;
    cv::line(legend, {at, gap + bar}, {at, gap + bar + lettering.px(2)}, {30, 30, 30});
    for (std::size_t i = 0; i < tick.labels.size(); ++i)
      lettering.write(legend, tick.labels[i], at - lettering.width(tick.labels[i]) / 2,
                      baseline(i));
  }
  lettering.write(legend, caption, gap, baseline(heads.size()));
  cv::Mat3b out;
  cv::vconcat(picture, legend, out);
  return out;
}

void require_pixels(bool empty) {
  if (empty) throw ArgumentError("an empty picture has no colours", "give one with pixels");
}

}  // namespace

cv::Mat3b false_colour_luminance(const RgbImage& light_cd_m2, double min_cd_m2, double max_cd_m2) {
  require_pixels(light_cd_m2.empty());
  if (!(min_cd_m2 > 0 && max_cd_m2 > min_cd_m2) || !std::isfinite(max_cd_m2))
    throw ArgumentError(
        fmt::format("a luminance scale from {} to {} cd/m2 is impossible", min_cd_m2, max_cd_m2),
        "give 0 < min < max");
  const ScalarImage luminance = luminance_cd_m2(light_cd_m2);
  const double low = std::log2(min_cd_m2), range = std::log2(max_cd_m2) - low;
  const cv::Mat3b map = colours(cv::COLORMAP_VIRIDIS);
  const cv::Mat3b picture = painted(luminance.pixels.size(), map, [&](int r, int c) {
    return (std::log2(std::max<double>(luminance.pixels(r, c), min_cd_m2)) - low) / range;
  });
  std::vector<Tick> ticks;
  for (int stop = static_cast<int>(std::ceil(low)); stop <= low + range; ++stop)
    ticks.push_back({(stop - low) / range,
                     {stop < 0 ? fmt::format("{:.2g}", std::exp2(stop))
                               : fmt::format("{:.0f}", std::exp2(stop)),
                      stop == 0 ? "0" : fmt::format("{:+d}", stop)}});
  return with_legend(picture, map, {"cd/m2", "stops"}, ticks, "luminance, 0 stops = 1 cd/m2");
}

cv::Mat3b false_colour_difference(const ScalarImage& difference, double top,
                                  const std::string& quantity) {
  require_pixels(difference.empty());
  if (!(top > 0) || !std::isfinite(top))
    throw ArgumentError(fmt::format("a difference scale up to {} is impossible", top),
                        "give a positive number");
  const cv::Mat3b map = colours(cv::COLORMAP_INFERNO);
  const cv::Mat3b picture = painted(difference.pixels.size(), map,
                                    [&](int r, int c) { return difference.pixels(r, c) / top; });
  std::vector<Tick> ticks;
  for (int i = 0; i < 4; ++i) ticks.push_back({i / 4.0, {fmt::format("{:.3g}", i * top / 4)}});
  const bool more = cv::countNonZero(difference.pixels > top) > 0;
  ticks.push_back({1, {fmt::format("{}{:.3g}", more ? ">= " : "", top)}});
  return with_legend(picture, map, {""}, ticks, quantity);
}

}  // namespace wheatstone
