#pragma once
// COLMAP models, text and binary (colmap.github.io/format.html). Converted while reading:
// COLMAP's first pixel has its centre at (0.5, 0.5), ours at (0, 0), so 0.5 is subtracted from
// principal points and observations. Poses are world-to-camera in both.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/import/imported_view.h"
#include "capture/import/pose_convention.h"

namespace wheatstone {

struct ColmapPoint {
  std::uint64_t id = 0;
  Eigen::Vector3d p_world_mm;
  std::array<std::uint8_t, 3> srgb = {};
  double error_px = 0;  // as COLMAP reports it
};

/// One tracked point in one picture; indices into ColmapModel's lists.
struct ColmapObservation {
  std::size_t view = 0, point = 0;
  Eigen::Vector2d pixel;
};

struct ColmapModel {
  std::vector<ImportedView> views;  // in the file's order
  std::vector<ColmapPoint> points;
  std::vector<ColmapObservation> observations;
  std::vector<std::string> missing_files;  // named in the model, not in the picture folder
};

/// The three files of a model as they lie in memory; `folder` is named in errors.
struct ColmapSource {
  std::filesystem::path folder;
  bool binary = false;
  std::string cameras, images, points;
};

/// Reads <model>/cameras, images and points3D, .bin before .txt; pictures lie in `pictures`.
/// COLMAP's unit is arbitrary: lengths are multiplied by `mm_per_unit`.
/// Errors: FileError with line or byte: missing or damaged files, camera models other than
/// SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, OPENCV_FISHEYE and FULL_OPENCV, names
/// that leave the folder; ArgumentError unless mm_per_unit > 0. Takes no more memory than the
/// files' lengths justify.
ColmapModel read_colmap(const std::filesystem::path& model, const std::filesystem::path& pictures,
                        double mm_per_unit = 1);
ColmapModel parse_colmap(const ColmapSource&, const std::filesystem::path& pictures,
                         double mm_per_unit = 1);

/// The observations as points of the world with their pixels, to verify the poses by.
std::vector<KnownPoint> known_points(const ColmapModel&);

/// Median distance in px between the observations and their points' projections, over one view
/// or all; points behind their camera count as infinitely far. ArgumentError if there are none.
double median_reprojection_error_px(const ColmapModel&, std::size_t view);
double median_reprojection_error_px(const ColmapModel&);

}  // namespace wheatstone
