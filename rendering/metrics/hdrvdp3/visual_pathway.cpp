#include "rendering/metrics/hdrvdp3/visual_pathway.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "rendering/metrics/hdrvdp3.h"
#include "rendering/metrics/hdrvdp3/gaussian_blur.h"
#include "rendering/metrics/hdrvdp3/plane.h"
#include "rendering/metrics/hdrvdp3/receptors.h"

namespace wheatstone {
namespace {

using RetinalImage = std::array<cv::Mat1d, 3>;  // R, G, B after glare, cd/m^2

RetinalImage retinal_image(const RgbImage& image, const EyeGlare& glare) {
  RetinalImage retinal;
  for (int k = 0; k < 3; ++k) {
    retinal[k] =
        make_plane(image.pixels.size(), [&](int r, int c) { return image.pixels(r, c)[k]; });
    glare.apply(retinal[k]);
    fill_plane(retinal[k], [&](int r, int c) { return std::clamp(retinal[k](r, c), 1e-5, 1e10); });
  }
  return retinal;
}

struct Excitation {
  double l, m, rod;
};

Excitation excite(const RetinalImage& retinal, const cv::Matx<double, 3, 4>& matrix, int r, int c) {
  const double rgb[] = {retinal[0](r, c), retinal[1](r, c), retinal[2](r, c)};
  const auto receptor = [&](int k) {
    return std::clamp(rgb[0] * matrix(0, k) + rgb[1] * matrix(1, k) + rgb[2] * matrix(2, k), 1e-8,
                      1e10);
  };
  return {receptor(0), receptor(1), receptor(3)};
}

/// Gaussian mean of log luminance; sigma 0.165 deg.
cv::Mat1d log_adaptation(const RetinalImage& retinal, const cv::Matx<double, 3, 4>& matrix,
                         double pixels_per_degree) {
  cv::Mat1d log_luminance = make_plane(retinal[0].size(), [&](int r, int c) {
    const Excitation e = excite(retinal, matrix, r, c);
    return std::log(std::max(e.l + e.m, 1e-6));
  });
  gaussian_blur(log_luminance, std::pow(10, -0.781367) * pixels_per_degree, BlurBorder::kReplicate);
  return log_luminance;
}

}  // namespace

VisualPathway::VisualPathway(cv::Size size, double pixels_per_degree, DisplaySpectra spectra)
    : glare_(size, pixels_per_degree), pixels_per_degree_(pixels_per_degree), spectra_(spectra) {}

VisualResponse VisualPathway::operator()(const RgbImage& image) const {
  const cv::Matx<double, 3, 4>& matrix = receptor_matrix(spectra_);
  const RetinalImage retinal = retinal_image(image, glare_);
  cv::Mat1d adaptation = log_adaptation(retinal, matrix, pixels_per_degree_);

  // The cones' and rods' sensitivities were measured by observers of age 28 with their pupils.
  const double area_deg2 =
      image.width() / pixels_per_degree_ * (image.height() / pixels_per_degree_);
  const double luminance = std::exp(cv::mean(adaptation)[0]);
  const double widening = pupil_diameter_mm(luminance, area_deg2, kHdrVdp3ObserverAgeYears) /
                          pupil_diameter_mm(luminance, area_deg2, 28);
  const double log_gain = 2 * std::log(widening);

  const LogTable &cone = cone_jnd(), &rod = rod_jnd();
  const auto log10_of = [&](double v) { return (std::log(v) + log_gain) / std::numbers::ln10; };
  const cv::Mat1d response = make_plane(retinal[0].size(), [&](int r, int c) {
    const Excitation e = excite(retinal, matrix, r, c);
    return cone(log10_of(e.l)) + cone(log10_of(e.m)) + rod(log10_of(e.rod));
  });
  fill_plane(adaptation, [&](int r, int c) { return std::exp(adaptation(r, c)); });
  return {response, adaptation};
}

}  // namespace wheatstone
