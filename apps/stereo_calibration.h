#pragma once
// Stereo calibration from a folder of chessboard pictures to a result and files.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "apps/stations.h"
#include "calib/camera_solver.h"

namespace wheatstone::apps {

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
