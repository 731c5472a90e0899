#include "rendering/metrics/hdrvdp3/neural_csf.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "rendering/metrics/hdrvdp3/eye_optics.h"

namespace wheatstone {
namespace {

struct Parameters {
  double log10_luminance, q1, q2, q3, q4;
};
const double kLog2 = std::log10(2.0);
// Fitted for HDR-VDP-3; the luminances are 0.0002, 0.002, ... 20 and 150 cd/m^2.
const Parameters kParameters[] = {
    {kLog2 - 4, 1.26181, 4.27832, 0.361902, 3.11914},
    {kLog2 - 3, 0.893585, 4.27832, 0.361902, 2.18938},
    {kLog2 - 2, 0.84864, 3.57253, 0.530355, 3.12486},
    {kLog2 - 1, 0.699243, 3.94545, 0.68608, 4.41846},
    {kLog2, 0.530826, 4.25337, 0.866916, 4.65117},
    {kLog2 + 1, 0.459297, 3.78765, 0.981028, 4.33546},
    {std::log10(150.0), 0.312626, 4.15264, 0.952367, 3.22389},
};

Parameters parameters_at(double log10_luminance) {
  const auto last = std::prev(std::end(kParameters));
  if (log10_luminance <= kParameters[0].log10_luminance) return kParameters[0];
  if (log10_luminance >= last->log10_luminance) return *last;
  const auto above = std::find_if(std::begin(kParameters), last, [&](const Parameters& p) {
    return p.log10_luminance >= log10_luminance;
  });
  const Parameters &a = *std::prev(above), &b = *above;
  const double t = (log10_luminance - a.log10_luminance) / (b.log10_luminance - a.log10_luminance);
  return {log10_luminance, std::lerp(a.q1, b.q1, t), std::lerp(a.q2, b.q2, t),
          std::lerp(a.q3, b.q3, t), std::lerp(a.q4, b.q4, t)};
}

}  // namespace

double neural_csf(double rho_cpd, double luminance_cd_m2) {
  const Parameters p = parameters_at(std::log10(luminance_cd_m2));
  const double high = 1 + std::pow(p.q1 * rho_cpd, p.q2);
  const double low = std::pow(-std::expm1(-(rho_cpd / 7) * (rho_cpd / 7)), p.q3);
  return p.q4 / std::sqrt(high / low) / eye_mtf(rho_cpd);
}

LogTable neural_csf_table(double rho_cpd) {
  std::vector<double> sensitivity = LogTable::abscissae(256);
  for (double& s : sensitivity) s = neural_csf(rho_cpd, s);
  return LogTable(sensitivity);
}

}  // namespace wheatstone
