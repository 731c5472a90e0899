#pragma once
// Which way a file's pose matrices are meant, and how to tell from points whose pixels are known.

#include <Eigen/Core>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "capture/import/imported_view.h"

namespace wheatstone {

/// What a camera's x, y and z axes point to.
///   OpenCV: right, down, forward    OpenGL: right, up, backward    LLFF: down, right, backward
enum class CameraAxes { kOpenCv, kOpenGl, kLlff };

/// camera_to_world: the matrix takes camera to world coordinates, its last column is where the
/// camera stands; otherwise the other way round.
struct PoseConvention {
  CameraAxes axes = CameraAxes::kOpenCv;
  bool camera_to_world = false;
  friend bool operator==(const PoseConvention&, const PoseConvention&) = default;
};
inline constexpr PoseConvention kColmapConvention = {CameraAxes::kOpenCv, false};
inline constexpr PoseConvention kNerfConvention = {CameraAxes::kOpenGl, true};
inline constexpr PoseConvention kLlffConvention = {CameraAxes::kLlff, true};

/// "opencv world-to-camera", "opengl camera-to-world", "llff camera-to-world", ... The latter
/// throws ArgumentError and lists them.
std::string to_string(PoseConvention);
PoseConvention pose_convention_from_string(const std::string&);

/// A 3x4 matrix [R | t] as a file states it, t in mm, and our T_camera_world (OpenCV axes).
RigidTransform from_stated(const Eigen::Matrix<double, 3, 4>&, PoseConvention);
Eigen::Matrix<double, 3, 4> to_stated(const RigidTransform& T_camera_world, PoseConvention);

/// A point whose pixel in one view is known.
struct KnownPoint {
  std::size_t view = 0;
  Eigen::Vector3d p_world_mm;
  Eigen::Vector2d px;  // distorted pixels
};

/// Median distance in px between known pixels and projections; points behind their camera count as
/// infinitely far. ArgumentError if there is none.
double median_error_px(std::span<const ImportedView>, std::span<const KnownPoint>);

/// Checks the poses, read with the convention `taken`, against the known points. Returns the median
/// error. Errors: FileError when it is above 5 px: it names the convention under which the same
/// matrices fit, or says that none does. ArgumentError without points.
double require_convention(const std::filesystem::path& file, std::span<const ImportedView>,
                          std::span<const KnownPoint>, PoseConvention taken);

/// Four points of the world before the first camera with their pixels in every view that has them
/// in front: written into exported files so that a reader can check its convention.
std::vector<KnownPoint> check_points(std::span<const ImportedView>, double distance_mm);

}  // namespace wheatstone
