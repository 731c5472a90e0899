#include "capture/import/pose_convention.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr double kMaxMedianPx = 5;

constexpr PoseConvention kAll[] = {{CameraAxes::kOpenCv, false}, {CameraAxes::kOpenCv, true},
                                   {CameraAxes::kOpenGl, false}, {CameraAxes::kOpenGl, true},
                                   {CameraAxes::kLlff, false},   {CameraAxes::kLlff, true}};

/// Coordinates in the file's camera axes to OpenCV's.
Eigen::Matrix3d R_camera_stated(CameraAxes axes) {
  switch (axes) {
    case CameraAxes::kOpenCv:
      return Eigen::Matrix3d::Identity();
    case CameraAxes::kOpenGl:
      return Eigen::Vector3d(1, -1, -1).asDiagonal();
    case CameraAxes::kLlff:
      return (Eigen::Matrix3d() << 0, 1, 0, 1, 0, 0, 0, 0, -1).finished();
  }
  throw InternalError("no such camera axes");
}

}  // namespace

std::string to_string(PoseConvention c) {
  const std::string axes = c.axes == CameraAxes::kOpenCv   ? "opencv"
                           : c.axes == CameraAxes::kOpenGl ? "opengl"
                                                           : "llff";
  return axes + (c.camera_to_world ? " camera-to-world" : " world-to-camera");
}

PoseConvention pose_convention_from_string(const std::string& name) {
  std::string known;
  for (const PoseConvention c : kAll) {
    if (name == to_string(c)) return c;
    known += (known.empty() ? "" : ", ") + to_string(c);
  }
  throw ArgumentError("'" + name + "' is no pose convention", "use one of: " + known);
}

RigidTransform from_stated(const Eigen::Matrix<double, 3, 4>& m, PoseConvention c) {
  const RigidTransform stated = {m.leftCols<3>(), m.col(3)};
  const RigidTransform T_stated_world = c.camera_to_world ? stated.inverse() : stated;
  return RigidTransform{R_camera_stated(c.axes), Eigen::Vector3d::Zero()} * T_stated_world;
}

Eigen::Matrix<double, 3, 4> to_stated(const RigidTransform& T_camera_world, PoseConvention c) {
  const RigidTransform T_stated_world =
      RigidTransform{R_camera_stated(c.axes).transpose(), Eigen::Vector3d::Zero()} * T_camera_world;
  const RigidTransform stated = c.camera_to_world ? T_stated_world.inverse() : T_stated_world;
  Eigen::Matrix<double, 3, 4> m;
  m << stated.R, stated.t_mm;
  return m;
}

double median_error_px(std::span<const ImportedView> views, std::span<const KnownPoint> points) {
  if (points.empty())
    throw ArgumentError("no known points to reproject", "import a file that holds points");
  std::vector<double> errors;
  for (const KnownPoint& p : points) {
    const ImportedView& view = views[p.view];
    const Eigen::Vector3d p_camera = view.T_camera_world * p.p_world_mm;
    const double e = p_camera.z() > 0
                         ? (project(view.intrinsics, view.distortion, p_camera) - p.px).norm()
                         : std::numeric_limits<double>::infinity();
    errors.push_back(std::isnan(e) ? std::numeric_limits<double>::infinity() : e);
  }
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

double require_convention(const std::filesystem::path& file, std::span<const ImportedView> views,
                          std::span<const KnownPoint> points, PoseConvention taken) {
  const double error = median_error_px(views, points);
  if (error <= kMaxMedianPx) return error;
  char found[120];
  std::snprintf(found, sizeof found, " (%zu known points reproject to %.1f px in the median)",
                points.size(), error);
  const std::string problem = "its poses are not " + to_string(taken) + found;
  for (const PoseConvention c : kAll) {
    std::vector<ImportedView> turned(views.begin(), views.end());
    for (ImportedView& v : turned)
      v.T_camera_world = from_stated(to_stated(v.T_camera_world, taken), c);
    const double fits = median_error_px(turned, points);
    if (fits <= kMaxMedianPx) {
      std::snprintf(found, sizeof found, " (%.2f px)", fits);
      throw FileError(file, problem + "; " + to_string(c) + " fits" + found,
                      "convert the poses, or state the convention with --convention where the "
                      "format leaves it open");
    }
  }
  throw FileError(file, problem + ", and no convention fits",
                  "check that poses, points and camera belong together");
}

std::vector<KnownPoint> check_points(std::span<const ImportedView> views, double distance_mm) {
  std::vector<KnownPoint> points;
  if (views.empty()) return points;
  const ImportedView& first = views.front();
  const Intrinsics& k = first.intrinsics;
  for (const double share_x : {0.3, 0.7})
    for (const double share_y : {0.35, 0.65}) {
      // Different depths, so that a mirrored or inverted pose cannot fit by chance.
      const double z = distance_mm * (1 + 0.4 * share_x + 0.2 * share_y);
      const Eigen::Vector3d p_world =
          first.T_camera_world.inverse() *
          Eigen::Vector3d((share_x * k.width_px - k.cx_px) / k.fx_px * z,
                          (share_y * k.height_px - k.cy_px) / k.fy_px * z, z);
      for (std::size_t v = 0; v < views.size(); ++v)
        if (const Eigen::Vector3d p = views[v].T_camera_world * p_world; p.z() > 0)
          points.push_back({v, p_world, project(views[v].intrinsics, views[v].distortion, p)});
    }
  return points;
}

}  // namespace wheatstone
