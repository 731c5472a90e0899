#include "rendering/light_field/drlf.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace wheatstone {
namespace {

/// n_camera . x = distance_mm on the focal plane, in the virtual camera's frame.
struct PlaneInCamera {
  Eigen::Vector3d normal;
  double distance_mm;
};

PlaneInCamera plane_in_camera(const VirtualCamera& camera, const PlaneInWorld& plane) {
  const Eigen::Vector3d n = camera.T_camera_world.R * plane.normal;
  return {n, plane.offset_mm + n.dot(camera.T_camera_world.t_mm)};
}

void require_off_plane(const PlaneInCamera& plane) {
  if (std::isfinite(plane.distance_mm) && std::abs(plane.distance_mm) > 1e-9) return;
  throw ArgumentError("the virtual camera stands on the focal plane",
                      "move the focal plane into the scene");
}

Eigen::Vector3d inverse_depth_row(const VirtualCamera& camera, const PlaneInCamera& plane) {
  return (plane.normal.transpose() * camera.K.inverse()).transpose() / plane.distance_mm;
}

Eigen::Vector3d bilinear(const cv::Mat3f& image, double x, double y) {
  x = std::clamp(x, 0.0, image.cols - 1.0);
  y = std::clamp(y, 0.0, image.rows - 1.0);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, image.cols - 1), y1 = std::min(y0 + 1, image.rows - 1);
  const double u = x - x0, v = y - y0;
  const cv::Vec3f &a = image(y0, x0), &b = image(y0, x1), &c = image(y1, x0), &d = image(y1, x1);
  Eigen::Vector3d out;
  for (int k = 0; k < 3; ++k)
    out[k] = (1 - v) * ((1 - u) * a[k] + u * b[k]) + v * ((1 - u) * c[k] + u * d[k]);
  return out;
}

/// The weighted sum over the cameras that one pixel is made from.
class PixelSum {
 public:
  PixelSum(std::span<const LightFieldView> views, const DrlfGeometry& geometry,
           const DrlfOptions& options, const Eigen::Vector3d& pixel)
      : views_(views), geometry_(&geometry), options_(&options), pixel_(pixel) {}

  /// Adds `weight` of a camera; returns the share of it that the camera sees, 0..1.
  double add(int camera, double weight) {
    const cv::Mat3f& image = views_[camera].light_cd_m2.pixels;
    const Eigen::Vector3d q = geometry_->H_data_virtual[camera] * pixel_;
    weight_ += weight;
    if (!(q.z() > 0)) return 0;
    const double x = q.x() / q.z(), y = q.y() / q.z();
    // To the outer edge of the border pixels, so that a lone camera shows all of its image.
    const double inside =
        0.5 + std::min(std::min(x, image.cols - 1 - x), std::min(y, image.rows - 1 - y));
    const double seen = std::clamp(inside / std::max(options_->feather_px, 1e-6), 0.0, 1.0);
    if (!(seen > 0)) return 0;
    sum_ += weight * seen * bilinear(image, x, y);
    seen_weight_ += weight * seen;
    return seen;
  }

  void write(cv::Vec3f& light, float& coverage) const {
    const double share = weight_ > 0 ? seen_weight_ / weight_ : 0;
    if (!(share > 1e-6)) return;  // stays black, uncovered
    for (int k = 0; k < 3; ++k) light[k] = static_cast<float>(sum_[k] / seen_weight_);
    coverage = static_cast<float>(share);
  }

 private:
  std::span<const LightFieldView> views_;
  const DrlfGeometry* geometry_;
  const DrlfOptions* options_;
  Eigen::Vector3d pixel_, sum_ = Eigen::Vector3d::Zero();
  double weight_ = 0, seen_weight_ = 0;
};

void render_pixel(std::span<const LightFieldView> views, const CameraMesh& mesh,
                  const DrlfGeometry& geometry, const DrlfOptions& options,
                  const Eigen::Vector3d& pixel, cv::Vec3f& light, float& coverage) {
  if (!(geometry.inverse_depth_row.dot(pixel) > 0)) return;
  const Eigen::Vector2d st = aperture_point(geometry.H_aperture_virtual * pixel);
  const int n = static_cast<int>(views.size());
  const auto& positions = mesh.positions_mm();
  PixelSum sum(views, geometry, options, pixel);
  if (options.aperture == DrlfOptions::Aperture::kLinear) {
    const CellWeights w = mesh.weights_at(st);
    for (int k = 0; k < w.cell->camera_count; ++k) sum.add(w.cell->cameras[k], w.weights[k]);
  } else if (options.aperture == DrlfOptions::Aperture::kGaussian) {
    // Relative to the nearest camera, so that far from all of them the weights do not vanish.
    const double d0 = (positions[mesh.nearest(st)] - st).squaredNorm();
    const double s2 = options.gaussian_sigma_mm * options.gaussian_sigma_mm;
    for (int i = 0; i < n; ++i)
      sum.add(i, std::exp(((d0 - (positions[i] - st).squaredNorm()) / (2 * s2))));
  } else {
    double best = std::numeric_limits<double>::infinity();
    for (int i = 0; i < n; ++i) {
      const double d = (positions[i] - st).squaredNorm();
      if (d >= best) continue;
      PixelSum candidate(views, geometry, options, pixel);
      if (candidate.add(i, 1) <= 0) continue;
      best = d;
      sum = candidate;
    }
  }
  sum.write(light, coverage);
}

}  // namespace

Eigen::Matrix4d virtual_matrix(const VirtualCamera& camera, const PlaneInWorld& plane) {
  const PlaneInCamera p = plane_in_camera(camera, plane);
  Eigen::Matrix4d K = Eigen::Matrix4d::Identity(), P = Eigen::Matrix4d::Identity(),
                  E = Eigen::Matrix4d::Identity();
  K.topLeftCorner<2, 2>() = camera.K.topLeftCorner<2, 2>();
  // After P the third entry is the distance to the plane and the fourth is z, so the principal
  // point multiplies the fourth.
  K.topRightCorner<2, 1>() = camera.K.topRightCorner<2, 1>();
  P.row(2) << p.normal.transpose(), -p.distance_mm;
  P.row(3) << 0, 0, 1, 0;
  E.topLeftCorner<3, 3>() = camera.T_camera_world.R;
  E.topRightCorner<3, 1>() = camera.T_camera_world.t_mm;
  return K * P * E;
}

Eigen::Vector3d focal_plane_point(const Eigen::Matrix4d& M, const Eigen::Vector2d& pixel) {
  const Eigen::Vector4d X = M.inverse() * Eigen::Vector4d(pixel.x(), pixel.y(), 0, 1);
  return X.head<3>() / X.w();
}

Eigen::Matrix3d homography_data_virtual(const LightFieldView& view, const VirtualCamera& camera,
                                        const PlaneInWorld& plane) {
  const PlaneInCamera p = plane_in_camera(camera, plane);
  require_off_plane(p);
  const RigidTransform T_data_virtual = view.T_camera_world * camera.T_camera_world.inverse();
  return view.intrinsics.K() * (T_data_virtual.R * camera.K.inverse() +
                                T_data_virtual.t_mm * inverse_depth_row(camera, p).transpose());
}

DrlfGeometry make_drlf_geometry(std::span<const LightFieldView> views, const CameraMesh& mesh,
                                const VirtualCamera& camera, const DrlfOptions& options) {
  if (camera.width <= 0 || camera.height <= 0 || !(std::abs(camera.K.determinant()) > 1e-12))
    throw ArgumentError(fmt::format("an impossible virtual camera ({}x{} pixels, |det K| = {})",
                                    camera.width, camera.height, std::abs(camera.K.determinant())),
                        "give a size and focal lengths above 0");
  if (options.aperture == DrlfOptions::Aperture::kGaussian && !(options.gaussian_sigma_mm > 0))
    throw ArgumentError("the aperture's sigma is not positive", "give gaussian_sigma_mm > 0");
  if (!(options.feather_px >= 0))
    throw ArgumentError("the feather is negative", "give feather_px >= 0");
  const double length = options.focal_plane.normal.norm();
  if (!(std::abs(length - 1) < 1e-6))
    throw ArgumentError(fmt::format("the focal plane's normal has length {}", length),
                        "give a unit normal");
  DrlfGeometry out;
  for (const LightFieldView& view : views) {
    if (view.light_cd_m2.empty() || view.light_cd_m2.width() != view.intrinsics.width_px ||
        view.light_cd_m2.height() != view.intrinsics.height_px)
      throw ArgumentError(
          fmt::format("view '{}' has {}x{} pixels but intrinsics for {}x{}", view.name,
                      view.light_cd_m2.width(), view.light_cd_m2.height(), view.intrinsics.width_px,
                      view.intrinsics.height_px),
          "give the intrinsics of this image size");
    out.H_data_virtual.push_back(homography_data_virtual(view, camera, options.focal_plane));
  }
  out.H_aperture_virtual = mesh.aperture_from_ray(camera_centre(camera.T_camera_world)) *
                           camera.T_camera_world.R.transpose() * camera.K.inverse();
  out.inverse_depth_row = inverse_depth_row(camera, plane_in_camera(camera, options.focal_plane));
  return out;
}

DrlfResult render_drlf_cpu(std::span<const LightFieldView> views, const VirtualCamera& camera,
                           const DrlfOptions& options) {
  const CameraMesh mesh(views);
  const DrlfGeometry geometry = make_drlf_geometry(views, mesh, camera, options);
  DrlfResult out{RgbImage(camera.width, camera.height), ScalarImage(camera.width, camera.height)};
  tbb::parallel_for(tbb::blocked_range<int>(0, camera.height), [&](const auto& rows) {
    for (int j = rows.begin(); j < rows.end(); ++j)
      for (int i = 0; i < camera.width; ++i)
        render_pixel(views, mesh, geometry, options, Eigen::Vector3d(i, j, 1),
                     out.light_cd_m2.pixels(j, i), out.coverage.pixels(j, i));
  });
  return out;
}

}  // namespace wheatstone
