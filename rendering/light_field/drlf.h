#pragma once
// Dynamically reparameterised light field: a new view from posed photographs that are sharp on a
// movable focal plane. Source: Isaksen, McMillan, Gortler, SIGGRAPH 2000; reference
// drlf_lumigraph.md (Eq. 7.1-7.3 with K_V's last row corrected to [0 0 0 1]).
// Views are undistorted pinhole images; light is blended linearly, in cd/m^2.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/rig_types.h"
#include "rendering/light_field/camera_mesh.h"

namespace wheatstone {

/// A pinhole that no camera stood in. K in OpenCV pixels; skew allowed.
struct VirtualCamera {
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  RigidTransform T_camera_world;
  int width = 0, height = 0;
};

struct DrlfOptions {
  PlaneInWorld focal_plane;
  enum class Aperture {
    kNearest,  // the nearest camera that sees the point: no ghosts, jumps between cameras
    kLinear,   // interpolation in the cell around the ray: continuous in the eye's position
    kGaussian  // all cameras: synthetic depth of field
  };
  Aperture aperture = Aperture::kLinear;
  double gaussian_sigma_mm = 20;  // on the aperture
  double feather_px = 8;          // weights fade to 0 this close to a data image's border
};

struct DrlfResult {
  RgbImage light_cd_m2;  // black where coverage is 0
  ScalarImage coverage;  // 0..1: share of the aperture's weight whose cameras see the point
};

/// M = K_V P_V E_V (4x4): world point to (i z, j z, signed distance to the focal plane, z).
Eigen::Matrix4d virtual_matrix(const VirtualCamera&, const PlaneInWorld&);

/// The point of the focal plane under a virtual pixel: M^-1 (i, j, 0, 1).
Eigen::Vector3d focal_plane_point(const Eigen::Matrix4d& virtual_matrix,
                                  const Eigen::Vector2d& pixel);

/// H_data_virtual (3x3), data pixels under virtual pixels through the focal plane. The third entry
/// of H (i, j, 1) is > 0 iff data and virtual camera have the point on the same side (both before
/// or both behind). Errors of this and of all below: ArgumentError when the virtual camera stands
/// on the focal plane.
Eigen::Matrix3d homography_data_virtual(const LightFieldView&, const VirtualCamera&,
                                        const PlaneInWorld&);

/// What the CPU and the GPU renderer both work from; all 3x3 take (i, j, 1) of a virtual pixel.
struct DrlfGeometry {
  std::vector<Eigen::Matrix3d> H_data_virtual;  // one per view
  Eigen::Matrix3d H_aperture_virtual;           // to (s h, t h, h) for aperture_point()
  Eigen::Vector3d inverse_depth_row;            // . (i, j, 1) > 0: the point is in front
};
/// Errors: ArgumentError also for views without or of another size than their pixels, an
/// impossible virtual camera, sigma <= 0, feather < 0.
DrlfGeometry make_drlf_geometry(std::span<const LightFieldView>, const CameraMesh&,
                                const VirtualCamera&, const DrlfOptions&);

/// The reference renderer, in double precision. Same bytes for every number of threads.
DrlfResult render_drlf_cpu(std::span<const LightFieldView>, const VirtualCamera&,
                           const DrlfOptions&);

}  // namespace wheatstone
