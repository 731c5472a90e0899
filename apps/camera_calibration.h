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

/// The boards found in the pictures of a folder.
struct FoundBoards {
  int width_px = 0, height_px = 0;
  std::vector<BoardView> views;            // named by their path below the folder
  std::vector<std::string> without_board;  // pictures that do not show (enough of) the board
};

/// Finds the board in every JPEG, PNG, TIFF and BMP below `folder` whose relative path matches the
/// shell pattern `match` (* does not match /), in the order of names.
/// With `markers` it is a ChArUco board, of which kMinCorners corners are enough, not all on one
/// line.
/// Errors: FileError: no such folder, no picture, a damaged one, two sizes (names both), no board
/// in any picture, another ChArUco board; ArgumentError as check_charuco().
FoundBoards find_boards(const std::filesystem::path& folder, const std::string& match, const Board&,
                        const std::optional<CharucoMarkers>& markers, const Progress&);

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

struct StereoCalibrationOptions {
  std::filesystem::path images;
  std::string left, right;  // shell patterns of the two cameras' pictures
  Board board;
  DistortionModel model = DistortionModel::kRadtan5;
  std::optional<std::filesystem::path> out;
};

/// Pairs pictures by the number at the end of their names. The document
/// `wheatstone-stereo-calibration/1`; with `out` also left.yaml, right.yaml, camchain.yaml and
/// stereo.json. Errors: also when fewer than 3 pairs show the board to both.
nlohmann::json calibrate_stereo(const StereoCalibrationOptions&, const Progress&);

}  // namespace wheatstone::apps
