#include "sim/eye.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.h"

namespace wheatstone {
namespace {

void check(const EyeCamera& camera) {
  if (camera.width_px < 1 || camera.height_px < 1 || camera.subsamples < 1) {
    throw ArgumentError("an eye photograph of no size or no samples was asked for",
                        "use at least one pixel and one subsample");
  }
}

// Points of the far plane (rsb, mm) under sample (i, j) of n x n of pixel (x, y).
Eigen::Vector3d far_point(Eye eye, const EyeCamera& camera, double x_px, double y_px) {
  const Intrinsics k = EyePhotograph::intrinsics(eye, camera);
  const double depth = kEyeZMm - kFarPlaneZMm;
  const Eigen::Vector3d p_eye((x_px - k.cx_px) / k.fx_px * depth,
                              (y_px - k.cy_px) / k.fy_px * depth, depth);
  return EyePhotograph::T_eye_rsb(eye).inverse() * p_eye;
}

// Bilinear, edge pixels extended to the border of the lit area, 0 outside it.
cv::Vec3f sample(const RgbImage& image, const Eigen::Vector2d& px) {
  if (px.x() < -0.5 || px.y() < -0.5 || px.x() > image.width() - 0.5 ||
      px.y() > image.height() - 0.5) {
    return {0, 0, 0};
  }
  const double x = std::clamp(px.x(), 0.0, image.width() - 1.0);
  const double y = std::clamp(px.y(), 0.0, image.height() - 1.0);
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const int i1 = std::min(i + 1, image.width() - 1), j1 = std::min(j + 1, image.height() - 1);
  const auto fx = static_cast<float>(x - i), fy = static_cast<float>(y - j);
  return (1 - fy) * ((1 - fx) * image.pixels(j, i) + fx * image.pixels(j, i1)) +
         fy * ((1 - fx) * image.pixels(j1, i) + fx * image.pixels(j1, i1));
}

}  // namespace

Intrinsics EyePhotograph::intrinsics(Eye eye, const EyeCamera& camera) {
  const Eigen::Vector3d centre = true_eye_centre_rsb_mm(eye);
  const double depth = kEyeZMm - kFarPlaneZMm;
  Intrinsics k;
  k.width_px = camera.width_px;
  k.height_px = camera.height_px;
  k.fx_px = camera.width_px * depth / kPanelWidthMm;
  k.fy_px = camera.height_px * depth / kPanelHeightMm;
  // The eye's foot point on the far plane, in pixels of the window.
  PanelModel window = true_panel_model({eye, Plane::kFar}, 1);
  window.lcd_width_px = camera.width_px;
  window.lcd_height_px = camera.height_px;
  const Eigen::Vector2d foot = lcd_px_at(window, centre.x(), centre.y());
  k.cx_px = foot.x();
  k.cy_px = foot.y();
  return k;
}

RigidTransform EyePhotograph::T_eye_rsb(Eye eye) {
  const Eigen::Matrix3d R = straight_R_camera_rsb();
  return {R, -(R * true_eye_centre_rsb_mm(eye))};
}

RgbImage EyePhotograph::photograph_displays(Eye eye, const EyeCamera& camera) const {
  check(camera);
  const DisplayId near_id{eye, Plane::kNear}, far_id{eye, Plane::kFar};
  const RgbImage near_light = world_.panel_light(near_id), far_light = world_.panel_light(far_id);
  const PanelModel &near_model = world_.model(near_id), &far_model = world_.model(far_id);
  const Eigen::Vector3d centre = true_eye_centre_rsb_mm(eye);
  const double to_near = (kEyeZMm - kNearPlaneZMm) / (kEyeZMm - kFarPlaneZMm);
  const int n = camera.subsamples;
  RgbImage out(camera.width_px, camera.height_px);
  tbb::parallel_for(0, camera.height_px, [&](int y) {
    for (int x = 0; x < camera.width_px; ++x) {
      cv::Vec3f sum(0, 0, 0);
      for (int s = 0; s < n * n; ++s) {
        const Eigen::Vector3d far =
            far_point(eye, camera, x + (s % n + 0.5) / n - 0.5, y + (s / n + 0.5) / n - 0.5);
        const Eigen::Vector3d near = centre + to_near * (far - centre);
        sum += sample(far_light, lcd_px_at(far_model, far.x(), far.y())) +
               sample(near_light, lcd_px_at(near_model, near.x(), near.y()));
      }
      out.pixels(y, x) = sum / static_cast<float>(n * n);
    }
  });
  return out;
}

RgbImage EyePhotograph::photograph_box(Eye eye, const EyeCamera& camera) const {
  check(camera);
  const Eigen::Vector3f centre = true_eye_centre_rsb_mm(eye).cast<float>();
  const int n = camera.subsamples;
  RgbImage out(camera.width_px, camera.height_px);
  tbb::parallel_for(0, camera.height_px, [&](int y) {
    std::vector<Ray> rays(static_cast<std::size_t>(n) * n);
    std::vector<Eigen::Vector3f> rgb(rays.size());
    for (int x = 0; x < camera.width_px; ++x) {
      for (int s = 0; s < n * n; ++s) {
        const Eigen::Vector3f far =
            far_point(eye, camera, x + (s % n + 0.5) / n - 0.5, y + (s / n + 0.5) / n - 0.5)
                .cast<float>();
        rays[static_cast<std::size_t>(s)] = {centre, far - centre};
      }
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int s = 0; s < n * n; s += Scene::kPacket) {
        const int count = std::min(Scene::kPacket, n * n - s);
        world_.scene.radiance(rays.data() + s, count, world_.light, rgb.data() + s);
      }
      for (const Eigen::Vector3f& v : rgb) sum += v;
      sum /= static_cast<float>(n * n);
      out.pixels(y, x) = {sum.x(), sum.y(), sum.z()};
    }
  });
  return out;
}

}  // namespace wheatstone
