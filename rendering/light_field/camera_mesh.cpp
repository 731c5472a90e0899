#include "rendering/light_field/camera_mesh.h"

#include <Eigen/SVD>
#include <cmath>
#include <limits>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr double kLineRatio = 0.1;         // second to first singular value
constexpr double kCoincidentRatio = 1e-6;  // of the spread of the centres

}  // namespace

CameraMesh::CameraMesh(std::span<const LightFieldView> views) {
  if (views.empty())
    throw ArgumentError("a light field without views", "give at least one posed view");
  const auto n = static_cast<Eigen::Index>(views.size());
  Eigen::Matrix3Xd centres(3, n);
  Eigen::Vector3d forward = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < n; ++i) {
    const RigidTransform& pose = views[static_cast<std::size_t>(i)].T_camera_world;
    centres.col(i) = camera_centre(pose);
    forward += pose.R.row(2).transpose();
  }
  origin_mm_ = centres.rowwise().mean();
  const Eigen::Matrix3Xd offsets = centres.colwise() - origin_mm_;
  const Eigen::JacobiSVD<Eigen::Matrix3Xd, Eigen::FullPivHouseholderQRPreconditioner> svd(
      offsets, Eigen::ComputeFullU);
  const double first = svd.singularValues()[0];
  const double second = n > 1 ? svd.singularValues()[1] : 0;
  is_line_ = !(second >= kLineRatio * first) || first == 0;
  if (is_line_) {
    // Many planes hold a line; the one that faces the scene keeps rays away from parallel to it.
    s_axis_ = first > 0 ? Eigen::Vector3d(svd.matrixU().col(0))
                        : Eigen::Vector3d(views[0].T_camera_world.R.row(0).transpose());
    normal_ = forward - s_axis_ * s_axis_.dot(forward);
    if (normal_.norm() < 1e-6 * static_cast<double>(n)) normal_ = s_axis_.unitOrthogonal();
    normal_.normalize();
  } else {
    s_axis_ = svd.matrixU().col(0);
    normal_ = svd.matrixU().col(2);
    if (normal_.dot(forward) < 0) normal_ = -normal_;
  }
  t_axis_ = normal_.cross(s_axis_);
  for (Eigen::Index i = 0; i < n; ++i)
    positions_mm_.emplace_back(s_axis_.dot(offsets.col(i)),
                               is_line_ ? 0.0 : t_axis_.dot(offsets.col(i)));
  if (is_line_)
    make_line_cells();
  else
    make_triangle_cells();
}

void CameraMesh::make_line_cells() {
  std::vector<int> order(positions_mm_.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return positions_mm_[a].x() < positions_mm_[b].x(); });
  const double spread = positions_mm_[order.back()].x() - positions_mm_[order.front()].x();
  int left = order.front();
  for (const int right : order) {
    const double s0 = positions_mm_[left].x(), s1 = positions_mm_[right].x();
    if (s1 - s0 <= kCoincidentRatio * spread) continue;  // `left` stands for its twins
    CameraCell cell;
    cell.camera_count = 2;
    cell.cameras = {left, right, 0};
    cell.a[0] = Eigen::Vector3d(-1, 0, s1) / (s1 - s0);
    cell.a[1] = Eigen::Vector3d(1, 0, -s0) / (s1 - s0);
    cells_.push_back(cell);
    left = right;
  }
  if (cells_.empty()) {
    CameraCell cell;
    cell.camera_count = 1;
    cell.cameras = {left, 0, 0};
    cell.a[0] = Eigen::Vector3d(0, 0, 1);
    cells_.push_back(cell);
  }
}

void CameraMesh::make_triangle_cells() {
  // Subdiv2D works in float inside a rectangle: bring the centres to 0..1000 first.
  Eigen::Vector2d low = positions_mm_[0], high = low;
  for (const auto& p : positions_mm_) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double scale = 1000 / (high - low).maxCoeff();
  cv::Subdiv2D subdivision(cv::Rect(-10, -10, 1020, 1020));
  const auto scaled = [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d q = (p - low) * scale;
    return cv::Point2f(static_cast<float>(q.x()), static_cast<float>(q.y()));
  };
  for (const auto& p : positions_mm_) subdivision.insert(scaled(p));
  std::vector<cv::Vec6f> triangles;
  subdivision.getTriangleList(triangles);
  for (const cv::Vec6f& triangle : triangles) {
    CameraCell cell;
    cell.camera_count = 3;
    Eigen::Matrix3d corners;  // columns (s, t, 1)
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector2d corner(triangle[2 * k], triangle[2 * k + 1]);
      cell.cameras[k] = nearest(low + corner / scale);
      corners.col(k) << positions_mm_[cell.cameras[k]], 1;
    }
    // Slivers along the hull interpolate badly and cover next to nothing.
    constexpr double kMinArea = 1e-4;
    if (std::abs(corners.determinant()) * scale * scale < kMinArea * 1000 * 1000) continue;
    const Eigen::Matrix3d a = corners.inverse();
    for (int k = 0; k < 3; ++k) cell.a[k] = a.row(k).transpose();
    cells_.push_back(cell);
  }
  WHEATSTONE_CHECK(cells_.size(), >, std::size_t{0});
}

Eigen::Matrix3d CameraMesh::aperture_from_ray(const Eigen::Vector3d& centre_world_mm) const {
  // centre + lambda ray on the plane: lambda = -normal.v / normal.ray with v = centre - origin.
  const Eigen::Vector3d v = centre_world_mm - origin_mm_;
  Eigen::Matrix3d out;
  out.row(0) = s_axis_.dot(v) * normal_ - normal_.dot(v) * s_axis_;
  out.row(1) = t_axis_.dot(v) * normal_ - normal_.dot(v) * t_axis_;
  out.row(2) = normal_;
  return out;
}

CellWeights CameraMesh::weights_at(const Eigen::Vector2d& st_mm) const {
  const Eigen::Vector3d p(st_mm.x(), st_mm.y(), 1);
  CellWeights best;
  double best_smallest = -std::numeric_limits<double>::infinity();
  for (const CameraCell& cell : cells_) {
    std::array<double, 3> w = {0, 0, 0};
    double smallest = std::numeric_limits<double>::infinity();
    for (int k = 0; k < cell.camera_count; ++k) {
      w[k] = cell.a[k].dot(p);
      smallest = std::min(smallest, w[k]);
    }
    if (smallest > best_smallest || !best.cell) {
      best_smallest = smallest;
      best = {&cell, w};
    }
  }
  double sum = 0;
  for (double& w : best.weights) sum += w = std::max(w, 0.0);
  for (double& w : best.weights) w /= sum;
  return best;
}

int CameraMesh::nearest(const Eigen::Vector2d& st_mm) const {
  int best = 0;
  for (int i = 1; i < static_cast<int>(positions_mm_.size()); ++i)
    if ((positions_mm_[i] - st_mm).squaredNorm() < (positions_mm_[best] - st_mm).squaredNorm())
      best = i;
  return best;
}

}  // namespace wheatstone
