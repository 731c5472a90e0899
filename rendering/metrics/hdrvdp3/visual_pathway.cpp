#include "rendering/metrics/hdrvdp3/visual_pathway.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "rendering/metrics/hdrvdp3.h"
#include "rendering/metrics/hdrvdp3/gaussian_blur.h"
#include "rendering/metrics/hdrvdp3/receptors.h"

namespace wheatstone {
namespace {

using RetinalImage = std::array<cv::Mat1d, 3>;  // R, G, B after glare, cd/m^2

RetinalImage retinal_image(const RgbImage& image, const EyeGlare& glare) {
  RetinalImage retinal;
  for (int k = 0; k < 3; ++k) {
    cv::Mat1d plane(image.pixels.size());
    for (int r = 0; r < plane.rows; ++r)
      for (int c = 0; c < plane.cols; ++c) plane(r, c) = image.pixels(r, c)[k];
    retinal[k] = cv::max(cv::min(glare(plane), 1e10), 1e-5);
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
  cv::Mat1d log_luminance(retinal[0].size());
  tbb::parallel_for(0, log_luminance.rows, [&](int r) {
    for (int c = 0; c < log_luminance.cols; ++c) {
      const Excitation e = excite(retinal, matrix, r, c);
      log_luminance(r, c) = std::log(std::max(e.l + e.m, 1e-6));
    }
  });
  return gaussian_blur(log_luminance, std::pow(10, -0.781367) * pixels_per_degree,
                       BlurBorder::kReplicate);
}

}  // namespace

VisualPathway::VisualPathway(cv::Size size, double pixels_per_degree, DisplaySpectra spectra)
    : glare_(size, pixels_per_degree), pixels_per_degree_(pixels_per_degree), spectra_(spectra) {}

VisualResponse VisualPathway::operator()(const RgbImage& image) const {
  const cv::Matx<double, 3, 4>& matrix = receptor_matrix(spectra_);
  const RetinalImage retinal = retinal_image(image, glare_);
  const cv::Mat1d log_adapted = log_adaptation(retinal, matrix, pixels_per_degree_);

  // The cones' and rods' sensitivities were measured by observers of age 28 with their pupils.
  const double area_deg2 =
      image.width() / pixels_per_degree_ * (image.height() / pixels_per_degree_);
  const double luminance = std::exp(cv::mean(log_adapted)[0]);
  const double widening = pupil_diameter_mm(luminance, area_deg2, kHdrVdp3ObserverAgeYears) /
                          pupil_diameter_mm(luminance, area_deg2, 28);
  const double log_gain = 2 * std::log(widening);

  const LogTable &cone = cone_jnd(), &rod = rod_jnd();
  VisualResponse out{cv::Mat1d(retinal[0].size()), cv::Mat1d(retinal[0].size())};
  tbb::parallel_for(0, image.height(), [&](int r) {
    const auto log10_of = [&](double v) { return (std::log(v) + log_gain) / std::numbers::ln10; };
    for (int c = 0; c < image.width(); ++c) {
      const Excitation e = excite(retinal, matrix, r, c);
      out.response_jnd(r, c) = cone(log10_of(e.l)) + cone(log10_of(e.m)) + rod(log10_of(e.rod));
      out.adaptation_cd_m2(r, c) = std::exp(log_adapted(r, c));
    }
  });
  return out;
}

}  // namespace wheatstone
