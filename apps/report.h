#pragma once
// A self-contained HTML page: pictures inside, plots as SVG, no script, no link outside.

#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry.h"
#include "core/image.h"

namespace wheatstone::apps {

/// Text as it must stand in HTML and SVG.
std::string escape_markup(const std::string& text);

class Report {
 public:
  explicit Report(const std::string& title);
  void heading(const std::string& text);
  void paragraph(const std::string& text);
  void table(const std::vector<std::string>& header,
             const std::vector<std::vector<std::string>>& rows);
  struct Picture {
    cv::Mat3b rgb;
    std::string caption;
  };
  void pictures(const std::vector<Picture>& row);
  /// Residual vectors as dots around zero; a ring of `ring_px` for scale.
  void residual_plot(const std::vector<Eigen::Vector2d>& residuals_px, double ring_px,
                     const std::string& caption);
  /// An SVG picture, as svg_of() makes it.
  void plot(const std::string& svg, const std::string& caption);
  void write(const std::filesystem::path&) const;

 private:
  std::string body_;
};

}  // namespace wheatstone::apps
