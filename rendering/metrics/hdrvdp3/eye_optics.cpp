#include "rendering/metrics/hdrvdp3/eye_optics.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "rendering/metrics/hdrvdp3/cosine_transform.h"
#include "rendering/metrics/hdrvdp3/plane.h"

namespace wheatstone {

double eye_mtf(double rho_cpd) {
  constexpr double kC1 = 0.061466549455263, kC2 = 0.99727370023777070;
  return kC2 * 0.426 * std::exp(-0.028 * rho_cpd) + kC2 * 0.574 * std::exp(-0.37 * rho_cpd) +
         (1 - kC2) * kC1 * std::exp(-37 * rho_cpd) +
         (1 - kC2) * (1 - kC1) * std::exp(-360 * rho_cpd);
}

EyeGlare::EyeGlare(cv::Size size, double pixels_per_degree) {
  const double y_cpd = pixels_per_degree / (2 * size.height);
  const double x_cpd = pixels_per_degree / (2 * size.width);
  gain_ = make_plane(size, [&](int r, int c) {
    const double y = r * y_cpd, x = c * x_cpd;
    return eye_mtf(std::sqrt(y * y + x * x));
  });
}

void EyeGlare::apply(cv::Mat1d& plane) const {
  WHEATSTONE_CHECK(plane.size(), ==, gain_.size());
  cosine_transform(plane);
  fill_plane(plane, [&](int r, int c) { return plane(r, c) * gain_(r, c); });
  inverse_cosine_transform(plane);
}

double pupil_diameter_mm(double luminance_cd_m2, double area_deg2, double age_years) {
  const double x = std::pow(luminance_cd_m2 * area_deg2 / 846, 0.41);
  const double d = 7.75 - 5.75 * x / (x + 2);
  return d + (std::clamp(age_years, 20.0, 83.0) - 28.58) * (0.02132 - 0.009562 * d);
}

}  // namespace wheatstone
