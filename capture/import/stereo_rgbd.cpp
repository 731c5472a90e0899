#include "capture/import/stereo_rgbd.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <string>

#include "core/error.h"

namespace wheatstone {
namespace {

EyeRgbd eye_from(std::span<const ExrView> views, const std::string& eye,
                 const std::filesystem::path& file) {
  const auto view =
      std::find_if(views.begin(), views.end(), [&](const ExrView& v) { return v.name == eye; });
  if (view == views.end())
    throw FileError(file, "has no view '" + eye + "'",
                    "render a multi-view EXR with the views left and right");
  const auto channel = [&](const std::string& name) -> const cv::Mat1f& {
    const auto found = view->channels.find(name);
    if (found == view->channels.end())
      throw FileError(file, "view '" + eye + "' has no channel " + name,
                      "export R, G, B and Z for both views");
    return found->second.pixels;
  };

  EyeRgbd out;
  const std::array<cv::Mat, 3> rgb = {channel("R"), channel("G"), channel("B")};
  out.z_units = ScalarImage(channel("Z").clone());
  if (rgb[0].size() != rgb[1].size() || rgb[0].size() != rgb[2].size() ||
      rgb[0].size() != out.z_units.pixels.size())
    throw FileError(file, "the channels of view '" + eye + "' differ in size",
                    "export the file again");
  cv::merge(rgb.data(), rgb.size(), out.light.pixels);
  try {
    require_valid_radiance(out.light, "the colour of view '" + eye + "'");
  } catch (const ArgumentError& e) {
    throw FileError(file, e.what(), "");
  }
  const bool has_alpha = view->channels.contains("A");
  const cv::Mat1f alpha = has_alpha ? channel("A") : cv::Mat1f();
  if (has_alpha && alpha.size() != rgb[0].size())
    throw FileError(file, "channel A of view '" + eye + "' differs in size",
                    "export the file again");
  out.mask.create(rgb[0].size());
  for (int y = 0; y < out.mask.rows; ++y) {
    for (int x = 0; x < out.mask.cols; ++x) {
      const float z = out.z_units.pixels(y, x);
      const bool there = std::isfinite(z) && z > 0 && (!has_alpha || alpha(y, x) > 0);
      out.mask(y, x) = there ? 255 : 0;
    }
  }
  return out;
}

}  // namespace

StereoRgbd stereo_rgbd(std::span<const ExrView> views, const std::filesystem::path& file) {
  StereoRgbd s{eye_from(views, "left", file), eye_from(views, "right", file)};
  if (s.left.mask.size() != s.right.mask.size())
    throw FileError(file, "the two views differ in size", "render both views alike");
  return s;
}

}  // namespace wheatstone
