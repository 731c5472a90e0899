#pragma once
// Camera calibration from a folder of chessboard pictures to a result, files and pictures.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/stations.h"
#include "calib/camera_solver.h"
#include "calib/charuco.h"

namespace wheatstone::apps {

struct CameraCalibrationOptions {
  std::filesystem::path images;
  std::string match = "*";
  Board board;
  std::optional<CharucoMarkers> charuco;  // else a chessboard
  DistortionModel model = DistortionModel::kRadtan5;
  bool without_outliers = false;             // leave the outlier boards out and solve again
  std::optional<std::filesystem::path> out;  // folder for files and pictures
};

/// The document `wheatstone-camera-calibration/1` of docs/camera_calibration.md. With `out` it is
/// written there as calibration.json, last, after camera.yaml (OpenCV), cameras.txt (COLMAP),
/// camchain.yaml (Kalibr, if it can hold the lens), coverage.png, uncertainty.png, uncertainty.exr.
/// Errors: as find_boards() and solve_camera().
nlohmann::json calibrate_camera(const CameraCalibrationOptions&, const Progress&);

}  // namespace wheatstone::apps
