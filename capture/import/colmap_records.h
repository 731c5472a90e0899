#pragma once
// The records of COLMAP's files as written, before units and pixel centres are converted.
// Internal to the COLMAP importer.

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "capture/import/colmap.h"

namespace wheatstone::colmap_detail {

/// Where a record starts, for errors.
struct Place {
  std::shared_ptr<const std::filesystem::path> file;  // shared: there is a place per point
  const char* unit = "line";                          // or "byte"
  std::size_t number = 0;

  /// Throws FileError "<file>: line 12 has <what>; <remedy>".
  [[noreturn]] void fail(const std::string& what) const;
};

struct Camera {
  Place place;
  std::uint64_t id = 0;
  std::string model;  // one of those that are read
  std::uint64_t width = 0, height = 0;
  std::vector<double> parameters;  // as many as the model has
};

struct Observation {
  double x = 0, y = 0;
  std::uint64_t point = 0;
};

struct Image {
  Place place;
  std::uint64_t id = 0, camera = 0;
  std::array<double, 4> q_wxyz = {};
  std::array<double, 3> t = {};
  std::string name;
  std::vector<Observation> observations;  // only those that belong to a point
};

struct Point {
  Place place;
  std::uint64_t id = 0;
  std::array<double, 3> xyz = {};
  std::array<std::uint8_t, 3> rgb = {};
  double error = 0;
};

struct Records {
  std::vector<Camera> cameras;
  std::vector<Image> images;
  std::vector<Point> points;
};

/// Checks syntax only. Errors: FileError.
Records read_records(const ColmapSource&);

}  // namespace wheatstone::colmap_detail
