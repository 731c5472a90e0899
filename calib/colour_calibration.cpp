#include "calib/colour_calibration.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <string>

#include "core/error.h"

namespace wheatstone {
namespace {

double luminance(const Eigen::Vector3d& rgb) {
  return kLuminanceWeights[0] * rgb[0] + kLuminanceWeights[1] * rgb[1] +
         kLuminanceWeights[2] * rgb[2];
}

constexpr double kSwapGain = 3;

/// Root mean square of the patches' relative colour errors under their own best matrix.
double misfit(const std::vector<ChartPatch>& patches) {
  const Eigen::Matrix3d M = fit_colour_matrix(patches, ChartWeighting::kRelative);
  double squares = 0;
  for (const ChartPatch& p : patches)
    squares += ((M * p.camera_rgb - p.reference) / p.reference.mean()).squaredNorm();
  return std::sqrt(squares / static_cast<double>(patches.size()));
}

}  // namespace

Eigen::Matrix3d fit_colour_matrix(const std::vector<ChartPatch>& patches,
                                  ChartWeighting weighting) {
  const auto n = static_cast<Eigen::Index>(patches.size());
  Eigen::MatrixX3d camera(n, 3), reference(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ChartPatch& p = patches[static_cast<std::size_t>(i)];
    const std::string name = "chart patch " + std::to_string(i);
    if (!p.camera_rgb.allFinite() || !p.reference.allFinite())
      throw ArgumentError(name + " is not finite", "measure it again");
    double weight = 1;
    if (weighting == ChartWeighting::kRelative) {
      if (!(p.reference.mean() > 0))
        throw ArgumentError(
            name + " has a reference with a mean of " + std::to_string(p.reference.mean()),
            "leave it out, or do not weigh by it");
      weight = 1 / p.reference.mean();
    }
    camera.row(i) = weight * p.camera_rgb.transpose();
    reference.row(i) = weight * p.reference.transpose();
  }
  if (n < 3)
    throw ArgumentError(std::to_string(n) + " chart patches do not determine a colour matrix",
                        "measure at least three of different colours");
  const Eigen::ColPivHouseholderQR<Eigen::MatrixX3d> qr(camera);
  if (qr.rank() < 3)
    throw ArgumentError("the camera colours of the chart patches do not span the colour space",
                        "measure patches of different colours");
  return qr.solve(reference).transpose();
}

std::optional<std::pair<std::size_t, std::size_t>> swapped_patches(
    std::vector<ChartPatch> patches) {
  double best = misfit(patches) / kSwapGain;
  std::optional<std::pair<std::size_t, std::size_t>> pair;
  for (std::size_t a = 0; a < patches.size(); ++a)
    for (std::size_t b = a + 1; b < patches.size(); ++b) {
      std::swap(patches[a].reference, patches[b].reference);
      if (const double exchanged = misfit(patches); exchanged < best) {
        best = exchanged;
        pair = {a, b};
      }
      std::swap(patches[a].reference, patches[b].reference);
    }
  return pair;
}

Eigen::Matrix3d scaled_to_patch(const Eigen::Matrix3d& M, const ChartPatch& patch) {
  const double seen = luminance(M * patch.camera_rgb), true_cd_m2 = luminance(patch.reference);
  if (!(seen > 0) || !(true_cd_m2 > 0))
    throw ArgumentError("the reference patch has no positive luminance", "choose a bright one");
  return true_cd_m2 / seen * M;
}

void set_colour_response(CameraProfile& camera, const Eigen::Matrix3d& M) {
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(M);
  if (!M.allFinite() || !lu.isInvertible())
    throw ArgumentError("the colour matrix has no inverse", "measure the chart again");
  const Eigen::Matrix3d camera_from_light = lu.inverse();
  const double to_white = camera_from_light.rowwise().sum().mean();
  if (!(to_white > 0))
    throw ArgumentError("the colour matrix gives white no positive response",
                        "measure the chart again");
  camera.dn_per_cd_m2_s = to_white;
  camera.camera_from_bt709 = camera_from_light / to_white;
}

}  // namespace wheatstone
