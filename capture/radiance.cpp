#include "capture/radiance.h"

#include <Eigen/LU>

#include "core/error.h"

namespace wheatstone {

RgbImage to_radiance(const cv::Mat3f& camera_rgb_dn_s, const CameraProfile& camera) {
  if (!(camera.dn_per_cd_m2_s > 0))
    throw ArgumentError("the camera profile's sensitivity is not positive",
                        "calibrate dn_per_cd_m2_s");
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(camera.camera_from_bt709);
  if (!lu.isInvertible())
    throw ArgumentError("the camera profile's colour matrix has no inverse",
                        "calibrate camera_from_bt709");
  const cv::Matx33f M = to_cv(lu.inverse() / camera.dn_per_cd_m2_s);
  RgbImage out(camera_rgb_dn_s.cols, camera_rgb_dn_s.rows);
  cv::transform(camera_rgb_dn_s, out.pixels, M);
  cv::max(out.pixels, 0, out.pixels);
  return out;
}

}  // namespace wheatstone
