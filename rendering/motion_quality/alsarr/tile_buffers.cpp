#include "rendering/motion_quality/alsarr/tile_buffers.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "core/exr.h"
#include "rendering/motion_quality/alsarr/shading_rate.h"

namespace wheatstone {
namespace {

/// Throws ArgumentError for the first tile whose value is not as wanted.
template <class Value, class Wanted>
void require_each(const cv::Mat_<Value>& buffer, const char* what, const char* remedy,
                  const Wanted& wanted) {
  for (int y = 0; y < buffer.rows; ++y)
    for (int x = 0; x < buffer.cols; ++x)
      if (!wanted(buffer(y, x)))
        throw ArgumentError(fmt::format("{} of tile ({}, {}) is {}", what, x, y, buffer(y, x)),
                            remedy);
}

/// One channel of a file's first view that has it.
cv::Mat1f read_channel(const std::filesystem::path& path, const std::vector<ExrView>& views,
                       const std::string& name) {
  for (const ExrView& view : views)
    if (const auto channel = view.channels.find(name); channel != view.channels.end())
      return channel->second.pixels;
  throw FileError(path, "has no channel '" + name + "'", "see docs/shading_rates.md for this file");
}

/// Indices stored as floating-point numbers.
cv::Mat1i as_indices(const std::filesystem::path& path, const cv::Mat1f& values, const char* what) {
  constexpr float kMaxIndex = 1e6F;
  cv::Mat1i out(values.size());
  for (int y = 0; y < values.rows; ++y)
    for (int x = 0; x < values.cols; ++x) {
      const float v = values(y, x);
      if (!(v >= 0 && v <= kMaxIndex) || v != std::floor(v))
        throw FileError(path, fmt::format("{} of tile ({}, {}) is {}", what, x, y, v),
                        "give whole numbers from 0");
      out(y, x) = static_cast<int>(v);
    }
  return out;
}

}  // namespace

TileBuffers TileBuffers::part(const cv::Rect& tiles) const {
  if (tiles.empty() || (tiles & cv::Rect({}, material.size())) != tiles)
    throw ArgumentError(
        fmt::format("{}x{} tiles from ({}, {}) do not lie in {}x{} tiles", tiles.width,
                    tiles.height, tiles.x, tiles.y, tiles_x(), tiles_y()),
        "choose a part inside the buffers");
  return {speed_x_deg_per_s(tiles), speed_y_deg_per_s(tiles), material(tiles), mip_level(tiles),
          luminance_cd_m2(tiles)};
}

void require_valid(const TileBuffers& b) {
  if (b.material.empty()) throw ArgumentError("tile buffers without tiles", "give a frame's tiles");
  const auto require_size = [&](const cv::Mat& buffer, const char* what) {
    if (buffer.size() != b.material.size())
      throw ArgumentError(fmt::format("the {} buffer has {}x{} tiles, the material buffer {}x{}",
                                      what, buffer.cols, buffer.rows, b.tiles_x(), b.tiles_y()),
                          "give all buffers of one frame the same size");
  };
  require_size(b.speed_x_deg_per_s, "x speed");
  require_size(b.speed_y_deg_per_s, "y speed");
  require_size(b.mip_level, "mip level");
  require_size(b.luminance_cd_m2, "luminance");
  const auto is_speed = [](double v) { return v >= 0 && std::isfinite(v); };
  const auto is_luminance = [](double v) { return v > 0 && std::isfinite(v); };
  const auto is_index = [](int v) { return v >= 0; };
  require_each(b.speed_x_deg_per_s, "the x speed", "give finite magnitudes in deg/s", is_speed);
  require_each(b.speed_y_deg_per_s, "the y speed", "give finite magnitudes in deg/s", is_speed);
  require_each(b.luminance_cd_m2, "the luminance", "give positive cd/m^2", is_luminance);
  require_each(b.material, "the material index", "count from 0", is_index);
  require_each(b.mip_level, "the mip level", "count from 0", is_index);
}

void require_valid(const FrameGeometry& g) {
  const auto require = [](const char* what, double v) {
    if (!(v > 0) || !std::isfinite(v))
      throw ArgumentError(fmt::format("the {} is {}", what, v), "give a positive number");
  };
  require("width in px", g.width_px);
  require("height in px", g.height_px);
  require("refresh rate in Hz", g.refresh_hz);
  require("number of pixels per degree", g.ppd);
}

TileBuffers read_tile_buffers(const TileBufferFiles& files, const FrameGeometry& geometry) {
  require_valid(geometry);
  const auto motion = read_exr_views(files.motion);
  const auto materials = read_exr_views(files.materials);
  TileBuffers out;
  // Buffer values are per cent of the frame per refresh.
  const double frames_to_deg = geometry.refresh_hz / geometry.ppd / 100;
  cv::Mat(cv::abs(read_channel(files.motion, motion, "R")))
      .convertTo(out.speed_x_deg_per_s, CV_64F, geometry.width_px * frames_to_deg);
  cv::Mat(cv::abs(read_channel(files.motion, motion, "G")))
      .convertTo(out.speed_y_deg_per_s, CV_64F, geometry.height_px * frames_to_deg);
  const cv::Size size = out.speed_x_deg_per_s.size();
  const auto require_size = [&](const std::filesystem::path& path, const cv::Mat& buffer) {
    if (buffer.size() != size)
      throw FileError(path,
                      fmt::format("has {}x{} tiles, {} has {}x{}", buffer.cols, buffer.rows,
                                  files.motion.string(), size.width, size.height),
                      "give buffers of one frame");
  };
  out.material =
      as_indices(files.materials, read_channel(files.materials, materials, "R"), "the material");
  out.mip_level =
      as_indices(files.materials, read_channel(files.materials, materials, "G"), "the mip level");
  require_size(files.materials, out.material);
  if (files.luminance) {
    read_channel(*files.luminance, read_exr_views(*files.luminance), "Y")
        .convertTo(out.luminance_cd_m2, CV_64F);
    require_size(*files.luminance, out.luminance_cd_m2);
  } else {
    out.luminance_cd_m2 = cv::Mat1d(size, files.uniform_luminance_cd_m2);
  }
  require_valid(out);
  return out;
}

cv::Size tile_count(int width_px, int height_px) {
  return {(width_px + kTileSize_px - 1) / kTileSize_px,
          (height_px + kTileSize_px - 1) / kTileSize_px};
}

cv::Mat1d tile_luminance_cd_m2(const RgbImage& image) {
  if (image.empty()) throw ArgumentError("an image without pixels", "give a frame");
  require_valid_radiance(image, "the frame");
  const cv::Mat1f luminance = luminance_cd_m2(image).pixels;
  cv::Mat1d out(tile_count(image.width(), image.height()));
  for (int y = 0; y < out.rows; ++y)
    for (int x = 0; x < out.cols; ++x) {
      const cv::Rect tile(x * kTileSize_px, y * kTileSize_px, kTileSize_px, kTileSize_px);
      out(y, x) = cv::mean(luminance(tile & cv::Rect({}, luminance.size())))[0] +
                  kTileLuminanceOffset_cd_m2;
    }
  return out;
}

}  // namespace wheatstone
