#include "apps/calibration_document.h"

#include "calib/camera_uncertainty.h"
#include "core/json.h"

namespace wheatstone::apps {

using nlohmann::json;

json camera_json(const CameraCalibration& c) {
  const Eigen::VectorXd sigma = c.sigma();
  std::vector<double> distortion_sigma(sigma.data() + 4, sigma.data() + sigma.size());
  return {{"width_px", c.intrinsics.width_px},
          {"height_px", c.intrinsics.height_px},
          {"fx_px", c.intrinsics.fx_px},
          {"fy_px", c.intrinsics.fy_px},
          {"cx_px", c.intrinsics.cx_px},
          {"cy_px", c.intrinsics.cy_px},
          {"fx_px_sigma", sigma[0]},
          {"fy_px_sigma", sigma[1]},
          {"cx_px_sigma", sigma[2]},
          {"cy_px_sigma", sigma[3]},
          {"distortion_model", to_string(c.model)},
          {"distortion_names", coefficient_names(c.model)},
          {"distortion", coefficients(c.distortion, c.model)},
          {"distortion_sigma", distortion_sigma},
          {"loose_coefficients", loose_coefficients(c)},
          {"covariance", to_json(c.covariance)},
          {"rms_px", c.rms_px},
          {"corner_sigma_px", c.corner_sigma_px}};
}

json transform_json(const RigidTransform& T) {
  return {{"R", to_json(Eigen::MatrixXd(T.R))}, {"t_mm", to_json(T.t_mm)}};
}

json board_json(const Board& board) {
  return {{"columns", board.columns}, {"rows", board.rows}, {"square_mm", board.square_mm}};
}

}  // namespace wheatstone::apps
