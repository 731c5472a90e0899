#include "capture/radiance.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"

namespace wheatstone {

namespace {

/// BT.709 light in cd/m^2 from camera colours in DN/s.
Eigen::Matrix3d bt709_from_camera(const CameraProfile& camera) {
  if (!(camera.dn_per_cd_m2_s > 0))
    throw ArgumentError("the camera profile's sensitivity is not positive",
                        "calibrate dn_per_cd_m2_s");
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(camera.camera_from_bt709);
  if (!lu.isInvertible())
    throw ArgumentError("the camera profile's colour matrix has no inverse",
                        "calibrate camera_from_bt709");
  return lu.inverse() / camera.dn_per_cd_m2_s;
}

}  // namespace

RgbImage to_radiance(const cv::Mat3f& camera_rgb_dn_s, const CameraProfile& camera) {
  const cv::Matx33f M = to_cv(bt709_from_camera(camera));
  RgbImage out(camera_rgb_dn_s.cols, camera_rgb_dn_s.rows);
  cv::transform(camera_rgb_dn_s, out.pixels, M);
  cv::max(out.pixels, 0, out.pixels);
  return out;
}

cv::Mat1f luminance_deviation(const MergedMosaic& merged, const CameraProfile& camera) {
  const cv::Mat1f& sigma = merged.sigma_dn_s;
  if (sigma.empty()) return {};
  if (sigma.rows < 2 || sigma.cols < 2)
    throw ArgumentError("the mosaic has less than one 2 x 2 cell", "give a larger one");
  const Eigen::RowVector3d luminance_from_camera =
      Eigen::Map<const Eigen::RowVector3d>(kLuminanceWeights.data()) * bt709_from_camera(camera);
  std::array<double, 4> weights2{};  // of the cell's four samples; of green there are two
  for (int i = 0; i < 4; ++i) {
    const int colour = bayer_colour(merged.mosaic.pattern, i / 2, i % 2);
    weights2[static_cast<std::size_t>(i)] =
        std::pow(luminance_from_camera[colour] / (colour == 1 ? 2 : 1), 2);
  }
  const auto own = [&](int r, int c, std::size_t i) {
    return weights2[i] * sigma(r, c) * sigma(r, c);
  };
  cv::Mat1f out(sigma.size());
  cv::parallel_for_(cv::Range(0, out.rows), [&](const cv::Range& rows) {
    for (int r = rows.start; r < rows.end; ++r)
      for (int c = 0; c < out.cols; ++c) {
        const int top = std::min(r, out.rows - 2) / 2 * 2, left = std::min(c, out.cols - 2) / 2 * 2;
        out(r, c) =
            static_cast<float>(std::sqrt(own(top, left, 0) + own(top, left + 1, 1) +
                                         own(top + 1, left, 2) + own(top + 1, left + 1, 3)));
      }
  });
  return out;
}

}  // namespace wheatstone
