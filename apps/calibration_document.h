#pragma once
// Parts that the results of camera and stereo calibrations share, docs/camera_calibration.md.

#include <nlohmann/json.hpp>

#include "calib/camera_solver.h"

namespace wheatstone::apps {

nlohmann::json camera_json(const CameraCalibration&);
nlohmann::json transform_json(const RigidTransform&);
nlohmann::json board_json(const Board&);

}  // namespace wheatstone::apps
