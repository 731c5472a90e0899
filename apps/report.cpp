#include "apps/report.h"

#include <fmt/format.h>

#include <algorithm>

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

}  // namespace

std::string escape_markup(const std::string& text) {
  std::string out;
  for (const char c : text)
    c == '<' ? out += "&lt;" : c == '>' ? out += "&gt;" : c == '&' ? out += "&amp;" : out += c;
  return out;
}

Report::Report(const std::string& title) {
  body_ = "<h1>" + escape_markup(title) + "</h1>\n";
}

void Report::heading(const std::string& text) {
  body_ += "<h2>" + escape_markup(text) + "</h2>\n";
}
void Report::paragraph(const std::string& text) {
  body_ += "<p>" + escape_markup(text) + "</p>\n";
}

void Report::table(const std::vector<std::string>& header,
                   const std::vector<std::vector<std::string>>& rows) {
  body_ += "<table><tr>";
  for (const std::string& h : header) body_ += "<th>" + escape_markup(h) + "</th>";
  body_ += "</tr>\n";
  for (const auto& row : rows) {
    body_ += "<tr>";
    for (const std::string& cell : row) body_ += "<td>" + escape_markup(cell) + "</td>";
    body_ += "</tr>\n";
  }
  body_ += "</table>\n";
}

void Report::pictures(const std::vector<Picture>& row) {
  body_ += "<div class=\"row\">\n";
  for (const Picture& p : row)
    body_ += fmt::format(
        "<figure><img src=\"data:image/png;base64,{}\" width=\"{}\" height=\"{}\" alt=\"{}\">"
        "<figcaption>{}</figcaption></figure>\n",
        base64(encode_picture_png(p.rgb)), p.rgb.cols, p.rgb.rows, escape_markup(p.caption),
        escape_markup(p.caption));
  body_ += "</div>\n";
}

void Report::residual_plot(const std::vector<Eigen::Vector2d>& residuals_px, double ring_px,
                           const std::string& caption) {
  constexpr double kHalf = 110;
  double reach = ring_px;
  for (const Eigen::Vector2d& r : residuals_px) reach = std::max(reach, r.norm());
  const double scale = 0.9 * kHalf / reach;
  body_ += fmt::format(
      "<figure class=\"plot\"><svg width=\"{0}\" height=\"{0}\" viewBox=\"-{1} -{1} {0} {0}\">"
      "<path d=\"M-{1} 0H{1}M0 -{1}V{1}\" stroke=\"#bbb\"/>"
      "<circle r=\"{2:.2f}\" fill=\"none\" stroke=\"#888\" stroke-dasharray=\"4 3\"/>"
      "<text x=\"4\" y=\"{3:.2f}\" font-size=\"11\">{4:g} px</text>",
      2 * kHalf, kHalf, ring_px * scale, -ring_px * scale - 3, ring_px);
  for (const Eigen::Vector2d& r : residuals_px)
    body_ += fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"2.2\" fill=\"#c0392b\"/>",
                         r.x() * scale, r.y() * scale);
  body_ += "</svg><figcaption>" + escape_markup(caption) + "</figcaption></figure>\n";
}

void Report::plot(const std::string& svg, const std::string& caption) {
  body_ += "<figure class=\"wide\">" + svg + "<figcaption>" + escape_markup(caption) +
           "</figcaption></figure>\n";
}

void Report::write(const std::filesystem::path& path) const {
  write_text_atomically(
      path,
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Wheatstone</title>"
      "<style>body{font:15px/1.5 sans-serif;margin:2em auto;max-width:1180px;padding:0 1em;"
      "color:#222}h2{margin-top:1.8em;border-bottom:1px solid #ccc}table{border-collapse:collapse;"
      "margin:1em 0}td,th{border:1px solid #ccc;padding:.25em .7em;text-align:left}"
      ".row{display:flex;flex-wrap:wrap;gap:12px}figure{margin:0 0 1em}img{max-width:100%;"
      "height:auto;background:#000}figcaption{font-size:13px;color:#555;max-width:400px}"
      ".row figure{flex:1 1 300px;max-width:384px}.plot{display:inline-block;margin-right:16px}"
      ".wide figcaption{max-width:760px}"
      "</style></head><body>\n" +
          body_ + "</body></html>\n");
}

}  // namespace wheatstone::apps
