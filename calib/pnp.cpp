#include "calib/pnp.h"

#include <Eigen/SVD>
#include <opencv2/calib3d.hpp>
#include <optional>
#include <vector>

#include "core/error.h"

namespace wheatstone {
namespace {

/// The frame whose z = 0 is the plane that all points lie on, if there is one. OpenCV's IPPE finds
/// that frame itself, but of points off z = 0 whose order is clockwise it makes a wrong pose.
std::optional<RigidTransform> plane_frame(std::span<const Eigen::Vector3d> p_a) {
  Eigen::Matrix3Xd m(3, static_cast<Eigen::Index>(p_a.size()));
  for (std::size_t i = 0; i < p_a.size(); ++i) m.col(static_cast<Eigen::Index>(i)) = p_a[i];
  const Eigen::Vector3d mean = m.rowwise().mean();
  m.colwise() -= mean;
  const Eigen::JacobiSVD<Eigen::Matrix3Xd> svd(m, Eigen::ComputeFullU);
  const Eigen::Vector3d s = svd.singularValues();
  if (!(s[2] < 1e-6 * s[0])) return std::nullopt;
  Eigen::Matrix3d axes = svd.matrixU();
  if (axes.determinant() < 0) axes.col(2) *= -1;
  return RigidTransform{axes.transpose(), -(axes.transpose() * mean)};
}

}  // namespace

RigidTransform pose_from_points(std::span<const Eigen::Vector3d> p_a,
                                std::span<const Eigen::Vector2d> seen_px, const Intrinsics& k,
                                const Distortion& d, const std::string& what) {
  if (p_a.size() < 4 || p_a.size() != seen_px.size())
    throw ArgumentError(what + ": " + std::to_string(seen_px.size()) + " image points for " +
                            std::to_string(p_a.size()) + " known points",
                        "give one image point per known point, at least 4");
  const std::optional<RigidTransform> plane = plane_frame(p_a);
  const RigidTransform T_object_a = plane.value_or(RigidTransform{});
  std::vector<cv::Point3d> object;
  std::vector<cv::Point2d> image;  // normalised, so the camera matrix is the identity
  for (std::size_t i = 0; i < p_a.size(); ++i) {
    const Eigen::Vector3d p = T_object_a * p_a[i];
    object.emplace_back(p.x(), p.y(), plane ? 0 : p.z());
    const double y = (seen_px[i].y() - k.cy_px) / k.fy_px;
    const double x = (seen_px[i].x() - k.cx_px - k.skew_px * y) / k.fx_px;
    const Eigen::Vector2d u = undistort(d, {x, y});
    image.emplace_back(u.x(), u.y());
  }
  cv::Mat rvec, tvec;
  bool found = false;
  // IPPE can end in NaN when the points are seen exactly head-on; the homography start does not.
  for (const auto method :
       {plane ? cv::SOLVEPNP_IPPE : cv::SOLVEPNP_SQPNP, cv::SOLVEPNP_ITERATIVE}) {
    if (method == cv::SOLVEPNP_ITERATIVE && !plane && p_a.size() < 6) break;
    try {
      found = cv::solvePnP(object, image, cv::Matx33d::eye(), cv::noArray(), rvec, tvec, false,
                           method) &&
              cv::checkRange(rvec) && cv::checkRange(tvec);
    } catch (const cv::Exception&) {
      found = false;  // degenerate points; reported below in our words
    }
    if (found) break;
  }
  if (!found)
    throw ArgumentError(what + ": no camera pose explains the known points",
                        "check the order of the points and the camera's intrinsics");
  cv::Matx33d R;
  cv::Rodrigues(rvec, R);
  const RigidTransform T_camera_object = {
      to_eigen(R), {tvec.at<double>(0), tvec.at<double>(1), tvec.at<double>(2)}};
  const RigidTransform T = T_camera_object * T_object_a;
  for (const Eigen::Vector3d& p : p_a)
    if (!((T * p).z() > 0))
      throw ArgumentError(what + ": the known points come out behind the camera",
                          "check the order of the points (mirrored image?)");
  return T;
}

}  // namespace wheatstone
