#include "capture/lamp_drift.h"

#include <fmt/format.h>

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

LampCorrection lamp_correction(const PatchReading& first, const PatchReading& view,
                               double largest_drift) {
  for (const PatchReading* reading : {&first, &view})
    if (!(reading->mean_dn_s > 0) || !std::isfinite(reading->mean_dn_s))
      throw ArgumentError(std::string("the monitor patch is dark") +
                              (reading == &first ? " in the first view" : ""),
                          "capture the view again");
  const double factor = first.mean_dn_s / view.mean_dn_s;
  if (std::abs(1 / factor - 1) > largest_drift)
    throw ArgumentError(
        fmt::format("the monitor patch has {:.3g} times the light of the first view's", 1 / factor),
        "check that nothing covers it, and capture the view again");
  return {factor, factor * std::hypot(first.sigma_dn_s / first.mean_dn_s,
                                      view.sigma_dn_s / view.mean_dn_s)};
}

}  // namespace wheatstone
