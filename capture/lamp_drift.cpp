#include "capture/lamp_drift.h"

#include <cmath>
#include <string>

#include "core/error.h"

namespace wheatstone {

PatchReading read_monitor_patch(const MergedMosaic& view, const cv::Rect& patch) {
  const cv::Rect inside = patch & cv::Rect({0, 0}, view.flags.size());
  if (patch.empty() || inside != patch)
    throw ArgumentError("the monitor patch is not inside of the view", "correct its rectangle");
  const int bad = cv::countNonZero(view.flags(patch) & (kSaturated | kUnderexposed));
  if (bad > 0)
    throw ArgumentError(std::to_string(bad) + " of " + std::to_string(patch.area()) +
                            " pixels of the monitor patch are saturated or too dark",
                        "choose another patch or other exposures");
  const auto count = static_cast<double>(patch.area());
  PatchReading out{cv::mean(view.mosaic.values(patch))[0]};
  if (!view.sigma_dn_s.empty())
    out.sigma_dn_s = cv::norm(view.sigma_dn_s(patch), cv::NORM_L2) / count;
  return out;
}

std::vector<LampCorrection> lamp_corrections(const std::vector<PatchReading>& readings,
                                             double largest_drift) {
  std::vector<LampCorrection> out;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const PatchReading &first = readings[0], &own = readings[i];
    const std::string name = "the monitor patch of view " + std::to_string(i);
    if (!(own.mean_dn_s > 0) || !std::isfinite(own.mean_dn_s))
      throw ArgumentError(name + " is dark", "capture the view again");
    const double factor = first.mean_dn_s / own.mean_dn_s;
    if (std::abs(1 / factor - 1) > largest_drift)
      throw ArgumentError(name + " has " + std::to_string(1 / factor) + " times its first light",
                          "check that nothing covers it, and capture the view again");
    const double sigma = i == 0 ? 0
                                : factor * std::hypot(first.sigma_dn_s / first.mean_dn_s,
                                                      own.sigma_dn_s / own.mean_dn_s);
    out.push_back({factor, sigma});
  }
  return out;
}

}  // namespace wheatstone
