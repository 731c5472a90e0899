#include "calib/gain_gamma_offset.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr double kDarkest_cd_m2 = 0.001;  // below it residuals are no longer relative

/// parameters: span, offset, gamma, black.
struct ReadingResidual {
  DriveReading seen;

  template <class T>
  bool operator()(const T* parameters, T* residual) const {
    const T base = (T(1) - parameters[1]) * seen.drive + parameters[1];
    T light = parameters[3];
    if (base > T(0)) light += parameters[0] * pow(base, parameters[2]);
    residual[0] = (light - seen.luminance_cd_m2) / std::max(seen.luminance_cd_m2, kDarkest_cd_m2);
    return true;
  }
};

GainGammaOffsetFit fit_from(const std::vector<DriveReading>& readings, double offset,
                            double gamma) {
  const auto [darkest, brightest] = std::minmax_element(
      readings.begin(), readings.end(), [](const DriveReading& a, const DriveReading& b) {
        return a.luminance_cd_m2 < b.luminance_cd_m2;
      });
  double parameters[4] = {brightest->luminance_cd_m2 - darkest->luminance_cd_m2, offset, gamma,
                          darkest->luminance_cd_m2};
  ceres::Problem problem;
  for (const DriveReading& r : readings)
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<ReadingResidual, 1, 4>(new ReadingResidual{r}), nullptr,
        parameters);
  problem.SetParameterLowerBound(parameters, 0, 1e-3 * parameters[0]);
  problem.SetParameterLowerBound(parameters, 1, -0.9);
  problem.SetParameterUpperBound(parameters, 1, 0.9);
  problem.SetParameterLowerBound(parameters, 2, 0.2);
  problem.SetParameterUpperBound(parameters, 2, 10);
  problem.SetParameterLowerBound(parameters, 3, 0);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 1000;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-15;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return {{parameters[0], parameters[1], parameters[2], parameters[3]},
          std::sqrt(2 * summary.final_cost / static_cast<double>(readings.size()))};
}

}  // namespace

double GainGammaOffset::luminance_cd_m2(double drive) const {
  return span_cd_m2 * std::pow(std::max(gain() * drive + offset, 0.0), gamma) + black_cd_m2;
}

double GainGammaOffset::drive(double luminance_cd_m2) const {
  const double level = std::max((luminance_cd_m2 - black_cd_m2) / span_cd_m2, 0.0);
  return std::clamp((std::pow(level, 1 / gamma) - offset) / gain(), 0.0, 1.0);
}

GainGammaOffsetFit fit_gain_gamma_offset(const std::vector<DriveReading>& readings) {
  std::set<double> drives;
  for (const DriveReading& r : readings) {
    if (!(r.drive >= 0 && r.drive <= 1))
      throw ArgumentError("a reading has the drive " + std::to_string(r.drive), "use 0 to 1");
    if (!(r.luminance_cd_m2 >= 0) || !std::isfinite(r.luminance_cd_m2))
      throw ArgumentError("the reading at drive " + std::to_string(r.drive) +
                              " is no luminance: " + std::to_string(r.luminance_cd_m2),
                          "measure it again");
    drives.insert(r.drive);
  }
  if (readings.size() < 5 || drives.size() < 3)
    throw ArgumentError("too few readings for four unknowns",
                        "measure at least five, at three or more drives");
  const auto by_drive = [](const DriveReading& a, const DriveReading& b) {
    return a.drive < b.drive;
  };
  const auto [lowest, highest] = std::minmax_element(readings.begin(), readings.end(), by_drive);
  if (!(highest->luminance_cd_m2 > lowest->luminance_cd_m2))
    throw ArgumentError("the readings do not rise with the drive", "check their order");
  // Where max() clips, the slope of the offset vanishes; several beginnings avoid to end there.
  GainGammaOffsetFit best = fit_from(readings, 0, 2.2);
  for (const double offset : {-0.1, 0.1})
    for (const double gamma : {1.2, 2.2}) {
      const GainGammaOffsetFit other = fit_from(readings, offset, gamma);
      if (other.relative_rms < best.relative_rms) best = other;
    }
  return best;
}

}  // namespace wheatstone
