#pragma once
// Which data cameras a ray is made from: interpolation over the aperture, the plane that holds the
// data cameras' centres. Source: reference drlf_lumigraph.md, "Aperture".

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "core/rig_types.h"

namespace wheatstone {

/// One to three cameras between which weights are affine: w_k = a[k] . (s, t, 1), sum w_k = 1.
struct CameraCell {
  int camera_count = 0;
  std::array<int, 3> cameras = {0, 0, 0};  // indices of views
  std::array<Eigen::Vector3d, 3> a = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                                      Eigen::Vector3d::Zero()};
};

/// The cell that interpolates at a point of the aperture; weights are >= 0 and sum to 1.
struct CellWeights {
  const CameraCell* cell = nullptr;
  std::array<double, 3> weights = {0, 0, 0};
};

/// The aperture plane of a set of cameras, with coordinates (s, t) in mm, and its cells.
/// Cameras on a line (a rail, a near-straight hand-held path: second singular value of the centres
/// below 0.1 of the first) get hat functions along it, t being ignored; others the Delaunay
/// triangles of their centres with barycentric weights.
class CameraMesh {
 public:
  /// Errors: ArgumentError without views.
  explicit CameraMesh(std::span<const LightFieldView>);

  bool is_line() const { return is_line_; }
  const std::vector<CameraCell>& cells() const { return cells_; }
  /// (s, t) of every view, mm; t = 0 on a line.
  const std::vector<Eigen::Vector2d>& positions_mm() const { return positions_mm_; }

  /// A for homogeneous (s h, t h, h) = A ray, where `ray_world` (any length) leaves
  /// `centre_world_mm`: the ray's meeting with the aperture. h = 0 for rays parallel to it.
  Eigen::Matrix3d aperture_from_ray(const Eigen::Vector3d& centre_world_mm) const;

  /// The cell with the largest smallest weight; outside all cells, its negative weights are 0 and
  /// the others renormalised.
  CellWeights weights_at(const Eigen::Vector2d& st_mm) const;
  /// Index of the view closest to (s, t).
  int nearest(const Eigen::Vector2d& st_mm) const;

 private:
  void make_line_cells();
  void make_triangle_cells();

  Eigen::Vector3d origin_mm_, s_axis_, t_axis_, normal_;  // in `world`
  bool is_line_ = false;
  std::vector<Eigen::Vector2d> positions_mm_;
  std::vector<CameraCell> cells_;
};

/// (s, t) of homogeneous (s h, t h, h); rays almost parallel to the aperture meet it far away.
inline Eigen::Vector2d aperture_point(const Eigen::Vector3d& homogeneous) {
  constexpr double kMinH = 1e-6;
  const double h = homogeneous.z();
  return homogeneous.head<2>() / (h < 0 ? std::min(h, -kMinH) : std::max(h, kMinH));
}

}  // namespace wheatstone
