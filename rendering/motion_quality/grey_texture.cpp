#include "rendering/motion_quality/grey_texture.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "core/error.h"
#include "core/exr.h"
#include "core/files.h"

namespace wheatstone {
namespace {

cv::Mat1d grey_of(const cv::Mat& red, const cv::Mat& green, const cv::Mat& blue) {
  cv::Mat1d r, g, b;
  red.convertTo(r, CV_64F);
  green.convertTo(g, CV_64F);
  blue.convertTo(b, CV_64F);
  return cv::Mat1d(kGreyWeights[0] * r + kGreyWeights[1] * g + kGreyWeights[2] * b);
}

cv::Mat1d read_exr_grey(const std::filesystem::path& path) {
  const std::vector<ExrView> views = read_exr_views(path);
  if (views.size() != 1)
    throw FileError(path, fmt::format("has {} views", views.size()), "give a file of one view");
  const auto& channels = views[0].channels;
  if (const auto y = channels.find("Y"); y != channels.end()) {
    cv::Mat1d grey;
    y->second.pixels.convertTo(grey, CV_64F);
    return grey;
  }
  if (!channels.contains("R") || !channels.contains("G") || !channels.contains("B"))
    throw FileError(path, "has neither channel Y nor R, G and B", "give a grey or an RGB file");
  return grey_of(channels.at("R").pixels, channels.at("G").pixels, channels.at("B").pixels);
}

cv::Mat1d read_picture_grey(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = read_bytes(path);
  cv::Mat picture;
  try {
    if (!bytes.empty())
      picture = cv::imdecode(
          cv::Mat(1, static_cast<int>(bytes.size()), CV_8U, const_cast<std::byte*>(bytes.data())),
          cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR);
  } catch (const cv::Exception&) {  // the same answer as an empty picture
  }
  if (picture.empty() || (picture.depth() != CV_8U && picture.depth() != CV_16U))
    throw FileError(path, "is no 8- or 16-bit picture", "give an EXR, PNG, JPEG or TIFF file");
  picture.convertTo(picture, CV_64F, 1.0 / (picture.depth() == CV_8U ? 255 : 65535));
  if (picture.channels() == 1) return picture;
  std::vector<cv::Mat> bgr;
  cv::split(picture, bgr);
  return grey_of(bgr[2], bgr[1], bgr[0]);
}

/// value(x, y) at every texel.
cv::Mat1d drawn(int width, int height, const std::function<double(int x, int y)>& value) {
  cv::Mat1d out(height, width);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) out(y, x) = value(x, y);
  return out;
}

/// Uniform noise, row by row, of the vectors' 32-bit linear congruential generator.
cv::Mat1d noise(int width, int height, std::uint32_t state) {
  return drawn(width, height, [&](int, int) {
    state = 1664525u * state + 1013904223u;
    return state * 0x1p-32;
  });
}

const std::map<std::string, std::function<cv::Mat1d()>>& procedural_textures() {
  static const std::map<std::string, std::function<cv::Mat1d()>> kTextures = {
      {"checker512",
       [] {
         return drawn(512, 512, [](int x, int y) { return 0.15 + 0.7 * ((x / 16 + y / 16) % 2); });
       }},
      {"gradient256",
       [] { return drawn(256, 256, [](int x, int) { return 0.05 + 0.9 * x / 255; }); }},
      {"noise128", [] { return noise(128, 128, 12345); }},
      {"noise640x544", [] { return noise(640, 544, 777); }},
      {"checker100x60",
       [] {
         return drawn(100, 60, [](int x, int y) { return 0.2 + 0.6 * ((x / 7 + y / 7) % 2); });
       }},
  };
  return kTextures;
}

}  // namespace

cv::Mat1d read_grey_texture(const std::filesystem::path& path) {
  const bool exr = path.extension() == ".exr" || path.extension() == ".EXR";
  cv::Mat1d grey = exr ? read_exr_grey(path) : read_picture_grey(path);
  for (int r = 0; r < grey.rows; ++r)
    for (int c = 0; c < grey.cols; ++c)
      if (!std::isfinite(grey(r, c)))
        throw FileError(path, fmt::format("holds {} in column {}, row {}", grey(r, c), c, r),
                        "give a texture of finite values");
  return grey;
}

std::vector<std::string> procedural_texture_names() {
  std::vector<std::string> names;
  for (const auto& [name, draw] : procedural_textures()) names.push_back(name);
  return names;
}

cv::Mat1d procedural_texture(const std::string& name) {
  const auto& known = procedural_textures();
  const auto texture = known.find(name);
  if (texture == known.end())
    throw ArgumentError(fmt::format("'{}' is no procedural texture", name),
                        fmt::format("use one of {}", fmt::join(procedural_texture_names(), ", ")));
  return texture->second();
}

}  // namespace wheatstone
