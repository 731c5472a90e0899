#include "apps/shading_rate_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>

#include "core/error.h"

namespace wheatstone::apps {
namespace {

constexpr int kMargin_px = 24;
constexpr int kLine_px = 30;
const cv::Vec3b kPaper(250, 250, 248);
const cv::Scalar kInk(40, 40, 44);

/// Of each rate, R, G, B: lightness follows the cost; where two cost the same, the hue tells wide
/// (bluish) from high (reddish) blocks.
const std::array<cv::Vec3b, kShadingRateCount> kRateColours = {{{38, 32, 74},
                                                                {86, 52, 120},
                                                                {40, 82, 138},
                                                                {70, 120, 140},
                                                                {196, 116, 96},
                                                                {92, 172, 130},
                                                                {250, 224, 92}}};

void write_text(cv::Mat3b& picture, const std::string& text, cv::Point at, double size = 0.6) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_DUPLEX, size, kInk, 1, cv::LINE_AA);
}

int text_width(const std::string& text, double size = 0.6) {
  int baseline = 0;
  return cv::getTextSize(text, cv::FONT_HERSHEY_DUPLEX, size, 1, &baseline).width;
}

/// A page with a title line, room for `content` and a line for the legend.
struct Page {
  cv::Mat3b pixels;
  cv::Point content;  // top left
  cv::Point legend;   // first baseline

  Page(const cv::Size& size, const std::string& title)
      : content(kMargin_px, 2 * kLine_px), legend(kMargin_px, content.y + size.height + kLine_px) {
    const int width = std::max(size.width, text_width(title, 0.7));
    pixels = cv::Mat3b(legend.y + kLine_px, width + 2 * kMargin_px, kPaper);
    write_text(pixels, title, {kMargin_px, kLine_px + 6}, 0.7);
  }

  void put(const cv::Mat3b& picture) { picture.copyTo(pixels(cv::Rect(content, picture.size()))); }
};

/// Every tile a square, the frame about 1200 px wide.
cv::Mat3b enlarge_tiles(const cv::Mat3b& tiles) {
  const int side = std::clamp(1200 / tiles.cols, 1, 32);
  cv::Mat3b out;
  cv::resize(tiles, out, {}, side, side, cv::INTER_NEAREST);
  return out;
}

/// OpenCV's viridis, as R, G, B.
cv::Mat3b viridis(const cv::Mat1b& levels) {
  cv::Mat3b bgr, rgb;
  cv::applyColorMap(levels, bgr, cv::COLORMAP_VIRIDIS);
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return rgb;
}

/// One colour per tile.
cv::Mat3b rate_colours(const ShadingRateMap& map) {
  require_valid_rates(map);
  cv::Mat3b tiles(map.rate_index.size());
  for (int y = 0; y < tiles.rows; ++y)
    for (int x = 0; x < tiles.cols; ++x) tiles(y, x) = kRateColours[map.rate_index(y, x) - 1];
  return tiles;
}

/// The colours, and the share of tiles that have each.
void draw_legend(Page& page, const ShadingRateMap& map) {
  int x = page.legend.x;
  for (int k = 0; k < kShadingRateCount; ++k) {
    const int count = cv::countNonZero(map.rate_index == k + 1);
    cv::rectangle(page.pixels, cv::Rect(x, page.legend.y - 16, 24, 20), kRateColours[k],
                  cv::FILLED);
    write_text(page.pixels,
               fmt::format("{}  {:.1f} %", kShadingRates[k].name,
                           100.0 * count / static_cast<double>(map.rate_index.total())),
               {x + 32, page.legend.y});
    x += 170;
  }
}

}  // namespace

cv::Mat3b rate_map_picture(const ShadingRateMap& map, const std::string& title) {
  const cv::Mat3b picture = enlarge_tiles(rate_colours(map));
  Page page(picture.size(), title);
  page.put(picture);
  draw_legend(page, map);
  return page.pixels;
}

cv::Mat3b quality_map_picture(const std::vector<double>& quality, const ShadingRateMap& map,
                              const std::string& title) {
  require_valid_rates(map);
  WHEATSTONE_CHECK(quality.size(), ==, map.rate_index.total() * kShadingRateCount);
  cv::Mat1d gain(map.rate_index.size());
  std::size_t tile = 0;
  for (int x = 0; x < gain.cols; ++x)
    for (int y = 0; y < gain.rows; ++y, ++tile) {
      const double* q = quality.data() + tile * kShadingRateCount;
      gain(y, x) = q[map.rate_index(y, x) - 1] - q[0];
    }
  std::vector<double> sorted(gain.begin(), gain.end());
  const auto top = sorted.begin() + static_cast<std::ptrdiff_t>(0.99 * double(sorted.size() - 1));
  std::nth_element(sorted.begin(), top, sorted.end());
  const double scale = std::max(*top, 1e-9);
  cv::Mat1b levels;
  gain.convertTo(levels, CV_8U, 255 / scale);
  const cv::Mat3b picture = enlarge_tiles(viridis(levels));

  Page page(picture.size(), title);
  page.put(picture);
  cv::Mat1b ramp(20, 512);
  for (int x = 0; x < ramp.cols; ++x) ramp.col(x) = x / 2;
  const std::string low = "0", high = fmt::format("{:.2g} model units", scale);
  const int ramp_x = page.legend.x + text_width(low) + 10;
  write_text(page.pixels, low, page.legend);
  viridis(ramp).copyTo(page.pixels(cv::Rect(ramp_x, page.legend.y - 16, ramp.cols, ramp.rows)));
  write_text(page.pixels, high, {ramp_x + ramp.cols + 10, page.legend.y});
  return page.pixels;
}

cv::Mat3b side_by_side(const std::vector<ShadedPicture>& pictures, const std::string& title) {
  WHEATSTONE_CHECK(pictures.empty(), ==, false);
  const cv::Size original = pictures[0].rgb.size();
  const cv::Size size = original * std::max(1, 1024 / original.width);
  const int panels = static_cast<int>(pictures.size()) + 1;
  Page page({panels * size.width + (panels - 1) * kMargin_px, size.height + kLine_px}, title);
  int x = page.content.x;
  const auto add_panel = [&](const cv::Mat3b& rgb, const std::string& caption) {
    WHEATSTONE_CHECK(rgb.size(), ==, original);
    write_text(page.pixels, caption, {x, page.content.y + kLine_px - 12});
    cv::Mat3b enlarged;
    cv::resize(rgb, enlarged, size, 0, 0, cv::INTER_NEAREST);
    enlarged.copyTo(page.pixels(cv::Rect({x, page.content.y + kLine_px}, size)));
    x += size.width + kMargin_px;
  };
  for (const ShadedPicture& p : pictures) add_panel(p.rgb, p.caption);
  cv::Mat3b rates;
  const ShadingRateMap& map = pictures.back().map;
  cv::resize(rate_colours(map), rates, {}, kTileSize_px, kTileSize_px, cv::INTER_NEAREST);
  add_panel(rates(cv::Rect({}, original)), "rate of each tile, as allocated");
  draw_legend(page, map);
  return page.pixels;
}

}  // namespace wheatstone::apps
