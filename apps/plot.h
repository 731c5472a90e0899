#pragma once
// Plots of numbers as SVG pictures: axes with units, lines, points with error bars, a legend.

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace wheatstone::apps {

struct PlotAxis {
  std::string label;  // quantity and unit, e.g. "refresh rate (Hz)"
  bool logarithmic = false;
  std::optional<std::pair<double, double>> range = {};  // fitted to the data when not given
  std::vector<double> ticks = {};                       // round numbers when not given
};

/// One panel, the legend at its right. Lines and points of the same name share a colour and one
/// entry of the legend. More than seven names are coloured as a ramp, in the order they were added.
class Plot {
 public:
  Plot(std::string title, PlotAxis x, PlotAxis y);

  /// Errors: ArgumentError unless x and y have the same number, at least one, of finite values
  /// (above 0 on a logarithmic axis).
  void line(const std::string& name, const std::vector<double>& x, const std::vector<double>& y);
  /// Error bars from low to high where given; then as many as there are points.
  void points(const std::string& name, const std::vector<double>& x, const std::vector<double>& y,
              const std::vector<double>& low = {}, const std::vector<double>& high = {});
  void hide_legend() { legend_ = false; }

  /// The panel as an SVG group of the given size.
  std::string svg(double width_px, double height_px) const;

 private:
  struct Series {
    std::string name;
    bool is_line;
    std::vector<double> x, y, low, high;
  };
  void add(Series);
  std::vector<std::string> names() const;  // in order of appearance

  std::string title_;
  PlotAxis x_, y_;
  bool legend_ = true;
  std::vector<Series> series_;
};

/// The panels side by side, `columns` to a row, as an SVG picture. Errors: ArgumentError for no
/// panel or no column.
std::string svg_of(const std::vector<Plot>& panels, int columns = 1);
/// The same as a file. Atomic. Errors: FileError.
void write_svg(const std::filesystem::path&, const std::vector<Plot>& panels, int columns = 1);

}  // namespace wheatstone::apps
