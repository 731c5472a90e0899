#pragma once
// A self-contained HTML page: pictures inside, plots as SVG, no script, no link outside.

#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry.h"
#include "core/image.h"

namespace wheatstone::apps {

/// Text as it must stand in HTML and SVG, attributes included.
std::string escape_markup(const std::string& text);

class Report {
 public:
  explicit Report(std::string title) : title_(std::move(title)) {}

  void heading(const std::string& text);
  void paragraph(const std::string& text);
  /// A box that stands out: green if all is `good`, else amber. `lines` below its first one.
  void verdict(bool good, const std::string& headline, const std::vector<std::string>& lines = {});
  /// What to do, one after the other.
  struct Step {
    std::string text, command;  // the command may be empty
  };
  void steps(const std::vector<Step>&);
  /// Names at the left, one value each.
  void facts(const std::vector<std::pair<std::string, std::string>>& rows);
  /// Numbers are set to the right, so that their digits stand below each other; words to the left.
  enum class Cells { kNumbers, kWords };
  void table(const std::vector<std::string>& header,
             const std::vector<std::vector<std::string>>& rows, Cells = Cells::kNumbers);
  struct Picture {
    cv::Mat3b rgb;
    std::string caption;
  };
  /// Three to a row where the window is wide enough.
  void pictures(const std::vector<Picture>&);
  /// Residual vectors as dots around zero, inside a ring of a round number of pixels.
  void residual_plot(const std::vector<Eigen::Vector2d>& residuals_px, const std::string& caption);
  /// An SVG picture, as svg_of() makes it.
  void plot(const std::string& svg, const std::string& caption);
  /// All of another page, without its title.
  void append(const Report& other) { body_ += other.body_; }

  void write(const std::filesystem::path&) const;

 private:
  std::string title_, body_;
};

}  // namespace wheatstone::apps
