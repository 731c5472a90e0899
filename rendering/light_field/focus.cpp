#include "rendering/light_field/focus.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr int kNeighbours = 4;
constexpr int kRays = 20000;
constexpr float kTruncation = 0.1f;  // of the white of the encoded pictures: beyond it, occlusion
constexpr double kLeastShare =
    1 / 3.0;  // of the rays: a corner of the picture is no judge of depth

/// A neighbour's picture, gamma-encoded relative to `white`, with its pose from the reference.
struct Neighbour {
  cv::Mat1f encoded;
  Eigen::Matrix3d K;
  RigidTransform T_camera_reference;
};

/// Bilinear sample, or NaN outside.
float sample(const cv::Mat1f& image, double x, double y) {
  if (!(x >= 0 && y >= 0 && x <= image.cols - 1 && y <= image.rows - 1))
    return std::numeric_limits<float>::quiet_NaN();
  const int x0 = std::min(static_cast<int>(x), image.cols - 2);
  const int y0 = std::min(static_cast<int>(y), image.rows - 2);
  const auto u = static_cast<float>(x - x0), v = static_cast<float>(y - y0);
  return (1 - v) * ((1 - u) * image(y0, x0) + u * image(y0, x0 + 1)) +
         v * ((1 - u) * image(y0 + 1, x0) + u * image(y0 + 1, x0 + 1));
}

std::vector<Neighbour> nearest_views(std::span<const LightFieldView> views,
                                     const RigidTransform& T_reference_world) {
  const Eigen::Vector3d centre = camera_centre(T_reference_world);
  std::vector<double> distance;
  for (const LightFieldView& v : views)
    distance.push_back((camera_centre(v.T_camera_world) - centre).norm());
  std::vector<std::size_t> order(views.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return distance[a] < distance[b]; });
  order.resize(std::min<std::size_t>(order.size(), kNeighbours));

  std::vector<Neighbour> out;
  double white = 0;
  for (const std::size_t i : order) {
    if (views[i].light_cd_m2.width() < 2 || views[i].light_cd_m2.height() < 2)
      throw ArgumentError(fmt::format("view '{}' has no picture", views[i].name),
                          "give views of at least 2x2 pixels");
    const ScalarImage y = luminance_cd_m2(views[i].light_cd_m2);
    white = std::max(white, 4 * cv::mean(y.pixels)[0]);  // independent of single highlights
    out.push_back(
        {y.pixels, views[i].intrinsics.K(), views[i].T_camera_world * T_reference_world.inverse()});
  }
  for (Neighbour& n : out) {
    if (white > 0) n.encoded = n.encoded / white;
    cv::pow(n.encoded, 1 / 2.2, n.encoded);
  }
  return out;
}

/// The values of the neighbours that see one ray's point at one depth; how many they are.
int seen_by(const std::vector<Neighbour>& neighbours, const Eigen::Vector3d& ray, double depth_mm,
            std::array<float, kNeighbours>& values) {
  int seen = 0;
  for (const Neighbour& n : neighbours) {
    const Eigen::Vector3d p = n.T_camera_reference * (depth_mm * ray);
    if (p.z() <= 0) continue;
    const Eigen::Vector3d q = n.K * p;
    const float value = sample(n.encoded, q.x() / q.z(), q.y() / q.z());
    if (!std::isnan(value)) values[seen++] = value;
  }
  return seen;
}

/// Mean truncated deviation between the neighbours at one depth; infinity where too few rays are
/// seen by two of them.
double disagreement(const std::vector<Neighbour>& neighbours,
                    const std::vector<Eigen::Vector3d>& rays, double depth_mm) {
  std::array<float, kNeighbours> values{};
  // Most depths of a wide sweep fail this cheap test on a few rays.
  constexpr std::size_t kProbe = 101;
  std::size_t probed = 0, common = 0;
  for (std::size_t i = 0; i < rays.size(); i += kProbe, ++probed)
    common += seen_by(neighbours, rays[i], depth_mm, values) >= 2;
  if (static_cast<double>(common) < 0.5 * kLeastShare * static_cast<double>(probed))
    return std::numeric_limits<double>::infinity();

  double sum = 0;
  std::size_t count = 0;
  for (const Eigen::Vector3d& ray : rays) {
    const int seen = seen_by(neighbours, ray, depth_mm, values);
    if (seen < 2) continue;
    float mean = 0, deviation = 0;
    for (int k = 0; k < seen; ++k) mean += values[k];
    mean /= static_cast<float>(seen);
    for (int k = 0; k < seen; ++k) deviation += std::abs(values[k] - mean);
    sum += std::min(deviation / static_cast<float>(seen), kTruncation);
    ++count;
  }
  if (static_cast<double>(count) < kLeastShare * static_cast<double>(rays.size()))
    return std::numeric_limits<double>::infinity();
  return sum / static_cast<double>(count);
}

}  // namespace

PlaneInWorld find_focal_plane(std::span<const LightFieldView> views,
                              const RigidTransform& T_reference_world, double near_mm,
                              double far_mm, int steps) {
  if (!(near_mm > 0 && near_mm < far_mm && std::isfinite(far_mm)) || steps < 3)
    throw ArgumentError(fmt::format("cannot sweep {}..{} mm in {} steps", near_mm, far_mm, steps),
                        "give 0 < near < far and at least 3 steps");
  if (views.size() < 2)
    throw ArgumentError("one view cannot tell depth", "give at least two posed views");
  const std::vector<Neighbour> neighbours = nearest_views(views, T_reference_world);

  // Rays of the nearest view's pinhole, placed at the reference pose.
  const cv::Size size = neighbours[0].encoded.size();
  const double stride = std::max(1.0, std::sqrt(double(size.area()) / kRays));
  const Eigen::Matrix3d K_inverse = neighbours[0].K.inverse();
  std::vector<Eigen::Vector3d> rays;
  for (double y = stride / 2; y < size.height; y += stride)
    for (double x = stride / 2; x < size.width; x += stride) {
      const Eigen::Vector3d ray = K_inverse * Eigen::Vector3d(std::floor(x), std::floor(y), 1);
      rays.push_back(ray / ray.z());
    }

  const double first = 1 / far_mm, step = (1 / near_mm - 1 / far_mm) / (steps - 1);
  std::vector<double> cost(static_cast<std::size_t>(steps));
  tbb::parallel_for(
      0, steps, [&](int i) { cost[i] = disagreement(neighbours, rays, 1 / (first + i * step)); });
  const auto best = std::min_element(cost.begin(), cost.end());
  if (!std::isfinite(*best))
    throw ArgumentError("no depth is seen by two views",
                        "check the poses, and give the scene's near and far depth");
  const auto i = static_cast<int>(best - cost.begin());
  double position = i;
  if (i > 0 && i + 1 < steps && std::isfinite(cost[i - 1]) && std::isfinite(cost[i + 1])) {
    const double curvature = cost[i - 1] - 2 * cost[i] + cost[i + 1];
    if (curvature > 0) position += 0.5 * (cost[i - 1] - cost[i + 1]) / curvature;
  }
  const double depth_mm = 1 / (first + position * step);
  PlaneInWorld plane;
  plane.normal = T_reference_world.R.row(2).transpose();
  plane.offset_mm = plane.normal.dot(camera_centre(T_reference_world)) + depth_mm;
  return plane;
}

}  // namespace wheatstone
