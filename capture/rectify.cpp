#include "capture/rectify.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"

namespace wheatstone {
namespace {

struct Bounds {
  Eigen::Vector2d min, max;
};

std::array<Eigen::Vector3d, 4> corners(const CommonBox& box) {
  return {Eigen::Vector3d(box.min_mm.x(), box.min_mm.y(), box.z_mm),
          Eigen::Vector3d(box.max_mm.x(), box.min_mm.y(), box.z_mm),
          Eigen::Vector3d(box.min_mm.x(), box.max_mm.y(), box.z_mm),
          Eigen::Vector3d(box.max_mm.x(), box.max_mm.y(), box.z_mm)};
}

Bounds projected_bounds(const Intrinsics& k, const RigidTransform& T, const CommonBox& box) {
  if (!(box.max_mm.x() > box.min_mm.x()) || !(box.max_mm.y() > box.min_mm.y()))
    throw ArgumentError("the common rectangle is empty", "give max_mm above min_mm");
  Bounds b{Eigen::Vector2d::Constant(1e300), Eigen::Vector2d::Constant(-1e300)};
  for (const Eigen::Vector3d& p : corners(box)) {
    const Eigen::Vector2d px = project(k, Distortion{}, T * p);
    b.min = b.min.cwiseMin(px);
    b.max = b.max.cwiseMax(px);
  }
  return b;
}

/// The largest upright rectangle of undistorted pixels that the photo shows, from its border.
Bounds photographed(const Intrinsics& k, const Distortion& d) {
  Bounds b{Eigen::Vector2d::Constant(-1e300), Eigen::Vector2d::Constant(1e300)};
  const auto undistorted = [&](double x_px, double y_px) {
    const double y = (y_px - k.cy_px) / k.fy_px, x = (x_px - k.cx_px - k.skew_px * y) / k.fx_px;
    const Eigen::Vector2d xy = undistort(d, {x, y});
    return Eigen::Vector2d(k.fx_px * xy.x() + k.skew_px * xy.y() + k.cx_px,
                           k.fy_px * xy.y() + k.cy_px);
  };
  constexpr int kSteps = 64;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = (k.width_px - 1.0) * i / kSteps, y = (k.height_px - 1.0) * i / kSteps;
    b.min.x() = std::max(b.min.x(), undistorted(0, y).x());
    b.max.x() = std::min(b.max.x(), undistorted(k.width_px - 1.0, y).x());
    b.min.y() = std::max(b.min.y(), undistorted(x, 0).y());
    b.max.y() = std::min(b.max.y(), undistorted(x, k.height_px - 1.0).y());
  }
  return b;
}

/// One more than the span for the pixels at both ends, one for the crop's whole-pixel position.
int needed(double span_px, int margin_px) {
  return static_cast<int>(std::ceil(span_px)) + 2 + 2 * margin_px;
}

std::array<float, 4> catmull_rom(float t) {
  return {0.5f * t * (-1 + t * (2 - t)), 1 + 0.5f * t * t * (3 * t - 5),
          0.5f * t * (1 + t * (4 - 3 * t)), 0.5f * t * t * (t - 1)};
}

cv::Vec3f sample(const cv::Mat3f& image, const Eigen::Vector2d& p) {
  if (p.x() < -0.5 || p.y() < -0.5 || p.x() > image.cols - 0.5 || p.y() > image.rows - 0.5)
    return {0, 0, 0};
  const int x0 = static_cast<int>(std::floor(p.x())), y0 = static_cast<int>(std::floor(p.y()));
  const auto wx = catmull_rom(static_cast<float>(p.x() - x0));
  const auto wy = catmull_rom(static_cast<float>(p.y() - y0));
  cv::Vec3f sum(0, 0, 0), low, high;
  for (int i = 0; i < 4; ++i) {
    const cv::Vec3f* row = image[std::clamp(y0 + i - 1, 0, image.rows - 1)];
    for (int j = 0; j < 4; ++j) {
      const cv::Vec3f& v = row[std::clamp(x0 + j - 1, 0, image.cols - 1)];
      sum += wy[static_cast<std::size_t>(i)] * wx[static_cast<std::size_t>(j)] * v;
      if (i == 1 && j == 1) low = high = v;
      if (i == 0 || i == 3 || j == 0 || j == 3) continue;
      for (int c = 0; c < 3; ++c) {
        low[c] = std::min(low[c], v[c]);
        high[c] = std::max(high[c], v[c]);
      }
    }
  }
  for (int c = 0; c < 3; ++c) sum[c] = std::max(std::clamp(sum[c], low[c], high[c]), 0.0f);
  return sum;
}

void require_size(const std::string& name, const RgbImage& distorted, const Intrinsics& k) {
  if (distorted.width() != k.width_px || distorted.height() != k.height_px)
    throw ArgumentError("view " + name + " is " + std::to_string(distorted.width()) + " x " +
                            std::to_string(distorted.height()) + " px, its intrinsics belong to " +
                            std::to_string(k.width_px) + " x " + std::to_string(k.height_px),
                        "use the profile of the camera that took the view");
}

/// Undistorted pixels (x0, y0) to (x0, y0) + size - 1, all of them photographed.
LightFieldView crop(const std::string& name, const RgbImage& distorted, const Intrinsics& k,
                    const Distortion& d, const RigidTransform& T_camera_rsb, double x0, double y0,
                    cv::Size size) {
  LightFieldView out;
  out.name = name;
  out.T_camera_world = T_camera_rsb;
  out.intrinsics = k;
  out.intrinsics.cx_px -= x0;
  out.intrinsics.cy_px -= y0;
  out.intrinsics.width_px = size.width;
  out.intrinsics.height_px = size.height;
  out.light_cd_m2 = RgbImage(size.width, size.height);
  cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& rows) {
    for (int r = rows.start; r < rows.end; ++r)
      for (int c = 0; c < size.width; ++c) {
        Eigen::Vector2d px(c + x0, r + y0);
        if (!d.is_zero()) {
          const double y = (px.y() - k.cy_px) / k.fy_px;
          const double x = (px.x() - k.cx_px - k.skew_px * y) / k.fx_px;
          const Eigen::Vector2d xy = distort(d, {x, y});
          px = {k.fx_px * xy.x() + k.skew_px * xy.y() + k.cx_px, k.fy_px * xy.y() + k.cy_px};
        }
        out.light_cd_m2.pixels(r, c) = sample(distorted.pixels, px);
      }
  });
  return out;
}

}  // namespace

cv::Size common_size(const Intrinsics& k, std::span<const RigidTransform> T_camera_rsb,
                     const CommonBox& box) {
  if (T_camera_rsb.empty())
    throw ArgumentError("no poses to find a common size for", "solve the poses first");
  cv::Size size;
  for (const RigidTransform& T : T_camera_rsb) {
    const Bounds b = projected_bounds(k, T, box);
    size.width = std::max(size.width, needed(b.max.x() - b.min.x(), box.margin_px));
    size.height = std::max(size.height, needed(b.max.y() - b.min.y(), box.margin_px));
  }
  return size;
}

LightFieldView rectify_to_common_box(const std::string& name, const RgbImage& distorted,
                                     const Intrinsics& k, const Distortion& d,
                                     const RigidTransform& T_camera_rsb, const CommonBox& box,
                                     cv::Size size) {
  require_size(name, distorted, k);
  const Bounds b = projected_bounds(k, T_camera_rsb, box);
  if (size.width < needed(b.max.x() - b.min.x(), box.margin_px) ||
      size.height < needed(b.max.y() - b.min.y(), box.margin_px))
    throw ArgumentError("view " + name + ": the common size is too small for its rectangle",
                        "compute it with common_size over all views");
  const Bounds shown = photographed(k, d);
  const Eigen::Vector2d middle = (b.min + b.max) / 2;
  if ((middle.array() < shown.min.array()).any() || (middle.array() > shown.max.array()).any() ||
      size.width - 1 > shown.max.x() - shown.min.x() ||
      size.height - 1 > shown.max.y() - shown.min.y())
    throw ArgumentError("view " + name + ": the photo does not hold the common rectangle",
                        "choose a smaller rectangle or camera positions nearer to the middle");
  const double x0 =
      std::clamp(std::round(middle.x() - (size.width - 1) / 2.0), std::ceil(shown.min.x()),
                 std::floor(shown.max.x()) - (size.width - 1));
  const double y0 =
      std::clamp(std::round(middle.y() - (size.height - 1) / 2.0), std::ceil(shown.min.y()),
                 std::floor(shown.max.y()) - (size.height - 1));

  return crop(name, distorted, k, d, T_camera_rsb, x0, y0, size);
}

LightFieldView rectify_to_own_box(const std::string& name, const RgbImage& distorted,
                                  const Intrinsics& k, const Distortion& d,
                                  const RigidTransform& T_camera_rsb, const CommonBox& box) {
  require_size(name, distorted, k);
  const Bounds b = projected_bounds(k, T_camera_rsb, box), shown = photographed(k, d);
  const Eigen::Array2d margin = Eigen::Array2d::Constant(box.margin_px);
  const Eigen::Array2d first = (b.min.array() - margin).floor().max(shown.min.array().ceil());
  const Eigen::Array2d last = (b.max.array() + margin).ceil().min(shown.max.array().floor());
  if ((last - first < 1).any())
    throw ArgumentError("view " + name + ": the photo does not show the rectangle",
                        "choose another rectangle or leave this camera position out");
  return crop(
      name, distorted, k, d, T_camera_rsb, first.x(), first.y(),
      {static_cast<int>(last.x() - first.x()) + 1, static_cast<int>(last.y() - first.y()) + 1});
}

}  // namespace wheatstone
