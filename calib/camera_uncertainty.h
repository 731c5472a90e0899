#pragma once
// What the covariance of a calibration means in the picture, and how to lessen it.

#include <string>
#include <vector>

#include "calib/camera_solver.h"
#include "core/image.h"

namespace wheatstone {

/// Standard deviation in px of where a distant point falls, at each pixel of the picture: root of
/// the summed variances of x and y. A change of the intrinsics that acts like a turn of the whole
/// camera does not count, because whoever uses the camera finds its pose anew with them; the turn
/// that absorbs most over the picture is taken out (the idea of mrcal's projection uncertainty).
/// NaN where the distortion model has no ray for the pixel.
ScalarImage projection_uncertainty_px(const CameraCalibration&);

/// Mean of that map's squares over a coarse grid, as a root.
double mean_uncertainty_px(const CameraCalibration&);

/// The board pose that would lessen the mean uncertainty most.
struct BoardAdvice {
  RigidTransform T_camera_board;
  double mean_then_px = 0;  // mean uncertainty with one more picture of this pose
  std::string text;         // for people
};

/// Tries 9 places, 2 distances and 5 tilts and weighs each by the information that its corners
/// would add, each with the calibration's corner_sigma_px. Throws ArgumentError when no pose shows
/// the whole board in the picture.
BoardAdvice next_board(const CameraCalibration&, const Board&);

/// Names of the distortion coefficients that are not determined one by one: a change by their
/// standard deviation alone would move the picture's farthest corner by more than a tenth of its
/// distance from the principal point, so that only their sum can be small. A sign of too many
/// terms.
std::vector<std::string> loose_coefficients(const CameraCalibration&);

}  // namespace wheatstone
