#include "rendering/metrics/hdrvdp3/receptors.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.h"

namespace wheatstone {
namespace {

/// Sensitivity of cones and rods together.
double joint_sensitivity(double l) {
  return 315.98 * std::pow(std::pow(6.7977 / l, 1.6008) + 1, -0.25534);
}

double rod_sensitivity(double l) {
  constexpr double kPeak = 1.1732;
  const double distance = std::abs(std::log10(l / kPeak));
  const double fall =
      l > kPeak ? std::pow(distance, 2.9899) / 0.5547 : std::pow(distance, 1.095) / 1.32;
  return std::pow(10, 1.8) * std::exp(-fall);
}

std::vector<double> rod_sensitivities(const std::vector<double>& l) {
  std::vector<double> out;
  for (const double x : l) out.push_back(rod_sensitivity(x));
  return out;
}

/// Half of what the rods leave of the joint sensitivity, at twice the excitation: L + M is
/// luminance, so one kind of cone has half of it. The original looks this up between the sampled
/// excitations, linearly; evaluating it there instead changes a response by 4e-6 of itself.
std::vector<double> cone_sensitivities(const std::vector<double>& l) {
  std::vector<double> both, out;
  for (const double x : l)
    both.push_back(std::max(joint_sensitivity(x) - rod_sensitivity(x), 1e-3));
  std::size_t i = 0;  // l[i] <= x <= l[i + 1]
  for (const double excitation : l) {
    const double x = std::min(2 * excitation, l.back());
    while (i + 2 < l.size() && l[i + 1] < x) ++i;
    out.push_back(0.5 * std::lerp(both[i], both[i + 1], (x - l[i]) / (l[i + 1] - l[i])));
  }
  return out;
}

/// Thresholds passed on the way up: the integral of S(l) dl / l, by the trapezoid rule.
LogTable count_thresholds(std::vector<double> (*sensitivities)(const std::vector<double>&)) {
  const std::vector<double> l = LogTable::abscissae(2048), s = sensitivities(l);
  const double scale = std::pow(10, 0.203943775672);
  std::vector<double> jnd = {0};
  for (std::size_t i = 1; i < l.size(); ++i)
    jnd.push_back(jnd.back() + scale * (s[i - 1] + s[i]) / 2 * std::log(l[i] / l[i - 1]));
  return LogTable(jnd);
}

}  // namespace

const cv::Matx<double, 3, 4>& receptor_matrix(DisplaySpectra spectra) {
  // Spectra of HDR-VDP 3.0.7 through cone fundamentals, rods and lens (hdrvdp3_intermediate.json).
  static const cv::Matx<double, 3, 4> led_lcd_srgb(                 //
      0.1582537046, 0.03216842209, 0.0001134419558, 0.03795391951,  //
      0.4475706152, 0.2814425391, 0.0008223321844, 0.6257346225,    //
      0.04186960986, 0.03869510924, 0.006977076859, 0.3661734837);
  static const cv::Matx<double, 3, 4> led_lcd_wcg(                  //
      0.201506882, 0.02735422272, 3.936508348e-05, 0.008649590761,  //
      0.4049048047, 0.2869988242, 0.0005824463351, 0.6442324746,    //
      0.04080418397, 0.03843108237, 0.007357481846, 0.3810119226);
  static const cv::Matx<double, 3, 4> oled(                        //
      0.1838834713, 0.02957062215, 1.78810487e-05, 0.00867417346,  //
      0.4119839021, 0.275796873, 0.0004100045743, 0.5338006961,    //
      0.05156673041, 0.04719840107, 0.00838647729, 0.4443501548);
  switch (spectra) {
    case DisplaySpectra::kLedLcdSrgb:
      return led_lcd_srgb;
    case DisplaySpectra::kLedLcdWcg:
      return led_lcd_wcg;
    case DisplaySpectra::kOled:
      return oled;
  }
  throw InternalError("unknown display spectra");
}

const LogTable& cone_jnd() {
  static const LogTable table = count_thresholds(cone_sensitivities);
  return table;
}

const LogTable& rod_jnd() {
  static const LogTable table = count_thresholds(rod_sensitivities);
  return table;
}

}  // namespace wheatstone
