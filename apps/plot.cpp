#include "apps/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/report.h"
#include "core/error.h"
#include "core/files.h"
#include "core/text.h"

namespace wheatstone::apps {
namespace {

// M. Okabe and K. Ito's colours, which stay apart for colour-blind readers.
constexpr std::array kColours = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                 "#e69f00", "#56b4e9", "#000000"};
// From short to long, for more names than that: no two alike, and neighbours differ in their
// dashes.
constexpr std::array<std::array<double, 3>, 6> kRamp = {
    {{58, 20, 92}, {38, 98, 190}, {0, 148, 130}, {120, 150, 20}, {224, 130, 0}, {168, 20, 40}}};
constexpr double kPanelWidth_px = 460, kPanelHeight_px = 340;
constexpr double kLeastLeft_px = 62, kRight_px = 16, kTop_px = 30, kBottom_px = 48;
constexpr double kLegendRow_px = 16;

/// How the lines and points of one name look.
struct Look {
  std::string colour, dashes;
};

Look look_of(std::size_t index, std::size_t count) {
  if (count <= kColours.size()) return {kColours[index], ""};
  const double at = static_cast<double>(index) / static_cast<double>(count - 1) *
                    static_cast<double>(kRamp.size() - 1);
  const std::size_t from = std::min(static_cast<std::size_t>(at), kRamp.size() - 2);
  const double share = at - static_cast<double>(from);
  std::string colour = "#";
  for (std::size_t c = 0; c < 3; ++c)
    colour += fmt::format("{:02x}",
                          std::lround((1 - share) * kRamp[from][c] + share * kRamp[from + 1][c]));
  return {colour, index % 2 == 1 ? " stroke-dasharray=\"6 3\"" : ""};
}

std::string text(double x, double y, const std::string& anchor, const std::string& content,
                 const std::string& more = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y,
                     anchor, more, escape_markup(content));
}

std::string segment(double x1, double y1, double x2, double y2, const std::string& style) {
  return fmt::format("<path d=\"M{:.2f} {:.2f}L{:.2f} {:.2f}\" {}/>\n", x1, y1, x2, y2, style);
}

/// One axis on paper: data to pixels, and where its ticks are.
class Scale {
 public:
  Scale(const PlotAxis& axis, double low, double high, double from_px, double to_px)
      : logarithmic_(axis.logarithmic), chosen_(axis.ticks), from_px_(from_px), to_px_(to_px) {
    if (axis.range) {
      low_ = value(axis.range->first);
      high_ = value(axis.range->second);
      return;
    }
    low_ = value(low);
    high_ = value(high);
    const double room = high_ > low_ ? 0.05 * (high_ - low_) : std::max(std::abs(low_), 1.0) / 2;
    low_ -= room;
    high_ += room;
  }

  double px(double v) const {
    return from_px_ + (value(v) - low_) / (high_ - low_) * (to_px_ - from_px_);
  }

  std::vector<double> ticks() const {
    std::vector<double> out;
    const auto add_if_inside = [&](double v) {
      const double slack = 1e-9 * (high_ - low_);
      if (value(v) >= low_ - slack && value(v) <= high_ + slack) out.push_back(v);
    };
    if (!chosen_.empty()) {
      for (const double tick : chosen_) add_if_inside(tick);
      return out;
    }
    if (logarithmic_) {
      for (int decade = int(std::floor(low_)); decade <= int(std::ceil(high_)); ++decade)
        for (const double step : {1.0, 2.0, 5.0}) add_if_inside(step * std::pow(10, decade));
      return out;
    }
    // About five steps of 1, 2 or 5 times a power of ten.
    const double raw = (high_ - low_) / 5, power = std::pow(10, std::floor(std::log10(raw)));
    const double step = power * (raw < 1.5 * power   ? 1
                                 : raw < 3.5 * power ? 2
                                 : raw < 7.5 * power ? 5
                                                     : 10);
    for (double k = std::ceil(low_ / step - 1e-9); k * step <= high_ * (1 + 1e-12) + 1e-9 * step;
         ++k)
      add_if_inside(k * step);
    return out;
  }

 private:
  double value(double v) const { return logarithmic_ ? std::log10(v) : v; }

  bool logarithmic_;
  std::vector<double> chosen_;
  double from_px_, to_px_, low_ = 0, high_ = 1;
};

/// Ticks print as short as they can; -0 and rounding noise as 0.
std::string tick_label(double v) {
  return fmt::format("{:.6g}", std::abs(v) < 1e-12 ? 0 : v);
}

}  // namespace

Plot::Plot(std::string title, PlotAxis x, PlotAxis y)
    : title_(std::move(title)), x_(std::move(x)), y_(std::move(y)) {
  for (const PlotAxis* axis : {&x_, &y_})
    if (axis->range && !(axis->range->first < axis->range->second &&
                         (!axis->logarithmic || axis->range->first > 0)))
      throw ArgumentError(fmt::format("'{}' from {} to {} is no range", axis->label,
                                      axis->range->first, axis->range->second),
                          "give the lower end first, above 0 on a logarithmic axis");
}

void Plot::line(const std::string& name, const std::vector<double>& x,
                const std::vector<double>& y) {
  add({name, true, x, y, {}, {}});
}

void Plot::points(const std::string& name, const std::vector<double>& x,
                  const std::vector<double>& y, const std::vector<double>& low,
                  const std::vector<double>& high) {
  add({name, false, x, y, low, high});
}

void Plot::add(Series s) {
  const auto bad = [](const PlotAxis& axis, const std::vector<double>& values) {
    return std::any_of(values.begin(), values.end(),
                       [&](double v) { return !std::isfinite(v) || (axis.logarithmic && v <= 0); });
  };
  if (s.x.empty() || s.x.size() != s.y.size() || s.low.size() != s.high.size() ||
      (!s.low.empty() && s.low.size() != s.y.size()))
    throw ArgumentError(fmt::format("'{}' has {} x, {} y, {} low and {} high values", s.name,
                                    s.x.size(), s.y.size(), s.low.size(), s.high.size()),
                        "give one of each for every point");
  if (bad(x_, s.x) || bad(y_, s.y) || bad(y_, s.low) || bad(y_, s.high))
    throw ArgumentError(fmt::format("'{}' holds a value that cannot be drawn", s.name),
                        "leave out NaN and infinity, and 0 and below on a logarithmic axis");
  series_.push_back(std::move(s));
}

std::vector<std::string> Plot::names() const {
  std::vector<std::string> out;
  for (const Series& s : series_)
    if (std::find(out.begin(), out.end(), s.name) == out.end()) out.push_back(s.name);
  return out;
}

std::string Plot::svg(double width_px, double height_px) const {
  const std::vector<std::string> all = names();
  double legend_px = 0;  // by about the width of the longest name
  for (const std::string& name : all)
    if (legend_) legend_px = std::max(legend_px, 33 + 6.5 * static_cast<double>(name.size()));
  const double right = width_px - kRight_px - legend_px, bottom = height_px - kBottom_px;
  std::vector<double> xs, ys;
  for (const Series& s : series_) {
    xs.insert(xs.end(), s.x.begin(), s.x.end());
    for (const auto* values : {&s.y, &s.low, &s.high})
      ys.insert(ys.end(), values->begin(), values->end());
  }
  if (xs.empty())
    throw ArgumentError(fmt::format("plot '{}' has nothing to show", title_), "add a line");
  const auto [x_low, x_high] = std::minmax_element(xs.begin(), xs.end());
  const auto [y_low, y_high] = std::minmax_element(ys.begin(), ys.end());
  const Scale y(y_, *y_low, *y_high, bottom, kTop_px);
  double left = kLeastLeft_px;  // room for the ticks' labels and the axis's
  for (const double tick : y.ticks())
    left = std::max(left, 30 + 6.7 * static_cast<double>(tick_label(tick).size()));
  const Scale x(x_, *x_low, *x_high, left, right);

  std::string out;
  for (const double tick : x.ticks()) {
    out += segment(x.px(tick), kTop_px, x.px(tick), bottom, "class=\"grid\"");
    out += text(x.px(tick), bottom + 16, "middle", tick_label(tick));
  }
  for (const double tick : y.ticks()) {
    out += segment(left, y.px(tick), right, y.px(tick), "class=\"grid\"");
    out += text(left - 6, y.px(tick) + 4, "end", tick_label(tick));
  }
  out += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" class=\"frame\"/>\n", left,
                     kTop_px, right - left, bottom - kTop_px);
  out += text((left + right) / 2, height_px - 10, "middle", x_.label);
  out +=
      text(0, 0, "middle", y_.label,
           fmt::format(" transform=\"translate(14 {:.1f}) rotate(-90)\"", (kTop_px + bottom) / 2));
  out += text((left + right) / 2, 20, "middle", title_, " class=\"title\"");

  const auto look = [&](const std::string& name) {
    const auto at = std::find(all.begin(), all.end(), name) - all.begin();
    return look_of(static_cast<std::size_t>(at), all.size());
  };
  // What a given range leaves out is cut off at the frame.
  out += fmt::format(
      "<svg x=\"{0}\" y=\"{1}\" width=\"{2}\" height=\"{3}\" "
      "viewBox=\"{0} {1} {2} {3}\">\n",
      left, kTop_px, right - left, bottom - kTop_px);
  for (const Series& s : series_) {
    const auto& [colour, dashes] = look(s.name);
    if (s.is_line) {
      out += "<path d=\"";
      for (std::size_t i = 0; i < s.x.size(); ++i)
        out += fmt::format("{}{:.2f} {:.2f}", i ? "L" : "M", x.px(s.x[i]), y.px(s.y[i]));
      out += fmt::format("\" class=\"line\" stroke=\"{}\"{}/>\n", colour, dashes);
      continue;
    }
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      if (!s.low.empty())
        out += segment(x.px(s.x[i]), y.px(s.low[i]), x.px(s.x[i]), y.px(s.high[i]),
                       fmt::format("class=\"bar\" stroke=\"{}\"", colour));
      out += fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"3\" fill=\"{}\"/>\n",
                         x.px(s.x[i]), y.px(s.y[i]), colour);
    }
  }
  out += "</svg>\n";
  // Of a long ramp every second, third, ... name stands for those between.
  const auto rows = static_cast<std::size_t>(std::max(1.0, (bottom - kTop_px) / kLegendRow_px));
  const std::size_t step = (all.size() + rows - 1) / rows;
  for (std::size_t i = 0, row = 0; legend_ && i < all.size(); i += step, ++row) {
    const double at = kTop_px + 10 + kLegendRow_px * static_cast<double>(row);
    out += segment(
        right + 8, at - 4, right + 26, at - 4,
        fmt::format("class=\"key\" stroke=\"{}\"{}", look(all[i]).colour, look(all[i]).dashes));
    out += text(right + 31, at, "start", all[i]);
  }
  return out;
}

std::string svg_of(const std::vector<Plot>& panels, int columns) {
  if (panels.empty() || columns < 1)
    throw ArgumentError(
        fmt::format("{} in {}", counted(panels.size(), "panel"), counted(columns, "column")),
        "give at least one of each");
  const auto count = static_cast<int>(panels.size());
  const int rows = (count + columns - 1) / columns;
  std::string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "viewBox=\"0 0 {0:.0f} {1:.0f}\">\n"
      "<style>text{{font:12px sans-serif;fill:#222}}.title{{font-weight:bold}}"
      ".grid{{stroke:#ddd}}.frame{{fill:none;stroke:#444}}"
      ".line{{fill:none;stroke-width:1.8}}.key{{stroke-width:3}}</style>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      kPanelWidth_px * std::min(columns, count), kPanelHeight_px * rows);
  for (int i = 0; i < count; ++i)
    out += fmt::format("<g transform=\"translate({} {})\">\n{}</g>\n",
                       kPanelWidth_px * (i % columns), kPanelHeight_px * (i / columns),
                       panels[static_cast<std::size_t>(i)].svg(kPanelWidth_px, kPanelHeight_px));
  return out + "</svg>\n";
}

void write_svg(const std::filesystem::path& path, const std::vector<Plot>& panels, int columns) {
  write_text_atomically(path, svg_of(panels, columns));
}

}  // namespace wheatstone::apps
