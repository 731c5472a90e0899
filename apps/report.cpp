#include "apps/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/files.h"
#include "core/png.h"

namespace wheatstone::apps {

namespace {

std::string base64(const std::vector<unsigned char>& bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    const unsigned triple =
        bytes[i] << 16 | (left > 1 ? bytes[i + 1] << 8 : 0) | (left > 2 ? bytes[i + 2] : 0);
    out += kDigits[triple >> 18];
    out += kDigits[triple >> 12 & 63];
    out += left > 1 ? kDigits[triple >> 6 & 63] : '=';
    out += left > 2 ? kDigits[triple & 63] : '=';
  }
  return out;
}

/// The first of 1, 2, 5, 10, ... times a power of ten that is not below `value`.
double round_up(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0})
    if (value <= step * power * (1 + 1e-9)) return step * power;
  return 10 * power;
}

constexpr const char* kStyle = R"(
body{font:16px/1.55 system-ui,"Segoe UI","DejaVu Sans",sans-serif;color:#1f2328;background:#fff;
  max-width:1120px;margin:2.2em auto 4em;padding:0 1.2em}
h1{font-size:1.8em;line-height:1.2;margin:0 0 .5em}
h2{font-size:1.25em;margin:2.2em 0 .6em;padding-bottom:.25em;border-bottom:1px solid #d5d9de}
p,ol{max-width:52em}
code{font:14px/1.5 ui-monospace,"DejaVu Sans Mono",monospace;background:#f1f3f5;border-radius:4px;
  padding:.15em .45em}
li{margin:.4em 0}
.verdict{border-left:6px solid;border-radius:4px;padding:.8em 1.2em;margin:1em 0}
.verdict strong{font-size:1.1em}
.verdict ul{margin:.5em 0 0;padding-left:1.2em}
.good{border-color:#2da44e;background:#eaf7ee}
.bad{border-color:#d4860b;background:#fff6e0}
.scroll{overflow-x:auto;margin:1em 0}
table{border-collapse:collapse;font-size:15px;font-variant-numeric:tabular-nums}
th,td{padding:.3em .9em;text-align:left;border-bottom:1px solid #e3e6ea;vertical-align:top}
thead th{border-bottom:2px solid #aab1b9;vertical-align:bottom}
tbody th{font-weight:normal;color:#555d66;white-space:nowrap}
.numbers td:not(:first-child),.numbers th:not(:first-child){text-align:right}
.row{display:grid;grid-template-columns:repeat(auto-fill,minmax(300px,1fr));gap:16px 14px;margin-bottom:1.2em}
figure{margin:0 0 1em}
.row figure{margin:0}
img{display:block;width:100%;height:auto;background:#000;border-radius:3px}
svg{max-width:100%;height:auto}
figcaption{font-size:14px;line-height:1.45;color:#555d66;margin-top:.35em;max-width:60em}
.residuals{display:inline-block;vertical-align:top;margin-right:2em}
.residuals figcaption{max-width:240px}
@media print{body{margin:0}figure,table{break-inside:avoid}h2{break-after:avoid}}
)";

}  // namespace

std::string escape_markup(const std::string& text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  return out;
}

void Report::heading(const std::string& text) {
  body_ += "<h2>" + escape_markup(text) + "</h2>\n";
}
void Report::paragraph(const std::string& text) {
  body_ += "<p>" + escape_markup(text) + "</p>\n";
}

void Report::verdict(bool good, const std::string& headline,
                     const std::vector<std::string>& lines) {
  body_ += fmt::format("<div class=\"verdict {}\"><strong>{}</strong>\n", good ? "good" : "bad",
                       escape_markup(headline));
  if (!lines.empty()) body_ += "<ul>\n";
  for (const std::string& line : lines) body_ += "<li>" + escape_markup(line) + "</li>\n";
  body_ += lines.empty() ? "</div>\n" : "</ul></div>\n";
}

void Report::steps(const std::vector<Step>& steps) {
  body_ += "<ol>\n";
  for (const Step& step : steps) {
    body_ += "<li>" + escape_markup(step.text);
    if (!step.command.empty()) body_ += "<br><code>" + escape_markup(step.command) + "</code>";
    body_ += "</li>\n";
  }
  body_ += "</ol>\n";
}

void Report::facts(const std::vector<std::pair<std::string, std::string>>& rows) {
  body_ += "<div class=\"scroll\"><table><tbody>\n";
  for (const auto& [name, value] : rows)
    body_ += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", escape_markup(name),
                         escape_markup(value));
  body_ += "</tbody></table></div>\n";
}

void Report::table(const std::vector<std::string>& header,
                   const std::vector<std::vector<std::string>>& rows, Cells cells) {
  body_ += fmt::format("<div class=\"scroll\"><table{}><thead><tr>",
                       cells == Cells::kNumbers ? " class=\"numbers\"" : "");
  for (const std::string& h : header) body_ += "<th>" + escape_markup(h) + "</th>";
  body_ += "</tr></thead><tbody>\n";
  for (const auto& row : rows) {
    body_ += "<tr>";
    for (const std::string& cell : row) body_ += "<td>" + escape_markup(cell) + "</td>";
    body_ += "</tr>\n";
  }
  body_ += "</tbody></table></div>\n";
}

void Report::pictures(const std::vector<Picture>& pictures) {
  body_ += "<div class=\"row\">\n";
  for (const Picture& p : pictures)
    body_ += fmt::format(
        "<figure><img src=\"data:image/png;base64,{}\" width=\"{}\" height=\"{}\" alt=\"{}\">"
        "<figcaption>{}</figcaption></figure>\n",
        base64(encode_picture_png(p.rgb)), p.rgb.cols, p.rgb.rows, escape_markup(p.caption),
        escape_markup(p.caption));
  body_ += "</div>\n";
}

void Report::residual_plot(const std::vector<Eigen::Vector2d>& residuals_px,
                           const std::string& caption) {
  constexpr double kHalf = 110, kRing = 0.88 * kHalf;
  double reach_px = 1e-6;
  for (const Eigen::Vector2d& r : residuals_px) reach_px = std::max(reach_px, r.norm());
  const double ring_px = round_up(reach_px), scale = kRing / ring_px;
  body_ += fmt::format(
      "<figure class=\"residuals\"><svg width=\"{0}\" height=\"{0}\" viewBox=\"-{1} -{1} {0} {0}\">"
      "<path d=\"M-{1} 0H{1}M0 -{1}V{1}\" stroke=\"#ccc\"/>"
      "<g fill=\"none\" stroke=\"#888\" stroke-dasharray=\"4 3\"><circle r=\"{2:.2f}\"/>"
      "<circle r=\"{3:.2f}\"/></g>"
      "<g font-size=\"11\"><text x=\"4\" y=\"-{4:.2f}\">{5:g} px</text>"
      "<text x=\"{1}\" y=\"12\" text-anchor=\"end\">x</text>"
      "<text x=\"-10\" y=\"{6:.2f}\">y</text></g>",
      2 * kHalf, kHalf, kRing, kRing / 2, kRing + 3, ring_px, kHalf - 2);
  for (const Eigen::Vector2d& r : residuals_px)
    body_ += fmt::format(
        "<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"2.2\" fill=\"#c0392b\" fill-opacity=\"0.7\"/>",
        r.x() * scale, r.y() * scale);
  body_ += "</svg><figcaption>" + escape_markup(caption) + "</figcaption></figure>\n";
}

void Report::plot(const std::string& svg, const std::string& caption) {
  body_ += "<figure>" + svg + "<figcaption>" + escape_markup(caption) + "</figcaption></figure>\n";
}

void Report::write(const std::filesystem::path& path) const {
  write_text_atomically(
      path, fmt::format("<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
                        "<meta name=\"viewport\" content=\"width=device-width\"><title>{0}</title>"
                        "<style>{1}</style></head><body>\n<h1>{0}</h1>\n{2}</body></html>\n",
                        escape_markup(title_), kStyle, body_));
}

}  // namespace wheatstone::apps
