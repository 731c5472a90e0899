#include "capture/exposure_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr double kFloorOfRange = 0.01;  // there photon noise is some per cent at most
constexpr std::int64_t kFewestPhotosites = 100;
constexpr double kLeastPileUp = 1e-3;
constexpr int kCodesBefore = 32;

/// How much more light the codes of `longer` hold; nothing where too few photosites tell.
std::optional<double> measured_ratio(const RawExposure& shorter, const RawExposure& longer,
                                     const MergeOptions& options) {
  double sum_shorter = 0, sum_longer = 0;
  std::int64_t count = 0;
  for (int r = 0; r < shorter.frame.height(); ++r)
    for (int c = 0; c < shorter.frame.width(); ++c) {
      const int a = shorter.frame.dn(r, c), b = longer.frame.dn(r, c);
      const double black = options.black_dn[static_cast<std::size_t>(2 * (r % 2) + c % 2)];
      if (a >= options.saturation_dn || b >= options.saturation_dn ||
          a - black < kFloorOfRange * (options.saturation_dn - black))
        continue;
      sum_shorter += a - black;
      sum_longer += b - black;
      ++count;
    }
  if (count < kFewestPhotosites) return std::nullopt;
  return sum_longer / sum_shorter;
}

}  // namespace

std::vector<ExposureRatio> contradicting_exposures(std::span<const RawExposure> stack,
                                                   const MergeOptions& options, double tolerance) {
  check_exposures(stack, options);
  std::vector<std::size_t> order(stack.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return stack[a].scale_s() < stack[b].scale_s();
  });
  std::vector<ExposureRatio> out;
  for (std::size_t i = 1; i < order.size(); ++i) {
    const RawExposure &shorter = stack[order[i - 1]], &longer = stack[order[i]];
    const std::optional<double> measured = measured_ratio(shorter, longer, options);
    if (!measured) continue;
    const double stated = longer.scale_s() / shorter.scale_s();
    if (std::abs(*measured / stated - 1) > tolerance)
      out.push_back({order[i - 1], order[i], stated, *measured});
  }
  return out;
}

PileUp pile_up(const MosaicImage& frame, int saturation_dn) {
  if (frame.dn.empty()) return {};
  double highest = 0;
  cv::minMaxLoc(frame.dn, nullptr, &highest);
  const int top = static_cast<int>(highest);
  if (top >= saturation_dn || top == 0) return {};
  std::int64_t at_top = 0, before = 0;
  for (const std::uint16_t dn : frame.dn) {
    at_top += dn == top;
    before += dn < top && dn >= top - kCodesBefore;
  }
  const double share = static_cast<double>(at_top) / static_cast<double>(frame.dn.total());
  const bool piled_up =
      share >= kLeastPileUp && 10 * before <= at_top * std::min(kCodesBefore, top);
  return piled_up ? PileUp{top, share} : PileUp{};
}

std::vector<std::string> exposure_warnings(std::span<const RawExposure> stack,
                                           const MergeOptions& options,
                                           std::span<const std::string> names) {
  if (names.size() != stack.size())
    throw ArgumentError("there are not as many names as exposures", "name each exposure");
  std::vector<std::string> out;
  for (const ExposureRatio& r : contradicting_exposures(stack, options))
    out.push_back(
        fmt::format("{} is {:.4g} times as bright as {}, but by time and gain it should be {:.4g} "
                    "times; check the times, the gains and the black level of both",
                    names[r.longer], r.measured, names[r.shorter], r.stated));
  for (std::size_t i = 0; i < stack.size(); ++i)
    if (const PileUp p = pile_up(stack[i].frame, options.saturation_dn); p.share > 0)
      out.push_back(fmt::format(
          "{:.2g} % of {} have its highest code {}, below the saturation {}; correct the "
          "saturation or the bits if that is where the sensor ends",
          100 * p.share, names[i], p.highest_dn, options.saturation_dn));
  return out;
}

}  // namespace wheatstone
