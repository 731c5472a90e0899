#include "capture/merge.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/error.h"

namespace wheatstone {
namespace {

void check(std::span<const RawExposure> stack, const CameraProfile& camera) {
  if (stack.empty()) throw ArgumentError("no exposures to merge", "capture at least one frame");
  if (!(camera.white_dn > camera.black_dn))
    throw ArgumentError("the camera profile's white level is not above its black level",
                        "check black_dn and white_dn");
  for (std::size_t i = 0; i < stack.size(); ++i) {
    const std::string name = "exposure " + std::to_string(i);
    const RawExposure& e = stack[i];
    if (e.frame.dn.empty()) throw ArgumentError(name + " has no pixels", "capture it again");
    if (e.frame.dn.size() != stack[0].frame.dn.size())
      throw ArgumentError(name + " is " + std::to_string(e.frame.width()) + " x " +
                              std::to_string(e.frame.height()) + " px but exposure 0 is " +
                              std::to_string(stack[0].frame.width()) + " x " +
                              std::to_string(stack[0].frame.height()) + " px",
                          "merge frames of one camera and one crop only");
    if (e.frame.pattern != stack[0].frame.pattern)
      throw ArgumentError(name + " has the colour pattern " + to_string(e.frame.pattern) +
                              " but exposure 0 has " + to_string(stack[0].frame.pattern),
                          "merge frames of one camera and one crop only");
    if (!(e.exposure.value() > 0) || !std::isfinite(e.exposure.value()))
      throw ArgumentError(
          name + " has an exposure time of " + std::to_string(e.exposure.value()) + " s",
          "give its time in seconds, above 0");
    if (!(e.gain > 0) || !std::isfinite(e.gain))
      throw ArgumentError(name + " has a gain of " + std::to_string(e.gain),
                          "give ISO / 100, above 0");
    for (std::size_t j = 0; j < i; ++j)
      if (stack[j].exposure == e.exposure && stack[j].gain == e.gain)
        throw ArgumentError(name + " has the same time and gain as exposure " + std::to_string(j),
                            "leave one of them out, or check the times");
  }
}

}  // namespace

MergedMosaic merge_exposures(std::span<const RawExposure> stack, const CameraProfile& camera) {
  check(stack, camera);
  std::size_t shortest = 0;
  for (std::size_t i = 1; i < stack.size(); ++i)
    if (stack[i].exposure.value() * stack[i].gain <
        stack[shortest].exposure.value() * stack[shortest].gain)
      shortest = i;

  const cv::Size size = stack[0].frame.dn.size();
  const BayerPattern pattern = stack[0].frame.pattern;
  MergedMosaic out;
  out.mosaic = {cv::Mat1f(size), pattern};
  out.sigma_dn_s.create(size);
  out.saturated = cv::Mat1b::zeros(size);
  const double electronics = camera.adc_noise * camera.adc_noise;
  const double read = camera.read_noise_e * camera.read_noise_e;

  cv::parallel_for_(cv::Range(0, (size.height + 1) / 2), [&](const cv::Range& range) {
    std::vector<std::size_t> used;
    for (int cell_row = range.start; cell_row < range.end; ++cell_row)
      for (int c0 = 0; c0 < size.width; c0 += 2) {
        // Odd sizes leave half cells at the right and bottom; their pixels decide alone.
        const cv::Rect cell = cv::Rect(c0, 2 * cell_row, 2, 2) & cv::Rect({0, 0}, size);
        const auto unsaturated = [&](std::size_t i) {
          for (int r = cell.y; r < cell.br().y; ++r)
            for (int c = cell.x; c < cell.br().x; ++c)
              if (stack[i].frame.dn(r, c) >= camera.white_dn) return false;
          return true;
        };
        used.clear();
        double time_s = 0;
        for (std::size_t i = 0; i < stack.size(); ++i) {
          const bool good = unsaturated(i);
          if (i == shortest && !good) out.saturated(cell) = 255;
          if (!good && i != shortest) continue;
          used.push_back(i);
          time_s += stack[i].exposure.value();
        }
        for (int r = cell.y; r < cell.br().y; ++r)
          for (int c = cell.x; c < cell.br().x; ++c) {
            double sum = 0;
            for (const std::size_t i : used)
              sum += (double(stack[i].frame.dn(r, c)) - camera.black_dn) / stack[i].gain;
            const double phi = sum / time_s;
            const auto colour = static_cast<std::size_t>(bayer_colour(pattern, r, c));
            const double k = camera.dn_per_electron[colour];
            double variance = 0;
            for (const std::size_t i : used) {
              const double g = stack[i].gain;
              const double x = std::max(phi, 0.0) * stack[i].exposure.value() * g;
              variance += (x * g * k + (read * g * g + electronics) * k * k) / (g * g);
            }
            out.mosaic.values(r, c) = static_cast<float>(phi);
            out.sigma_dn_s(r, c) = static_cast<float>(std::sqrt(variance) / time_s);
          }
      }
  });
  return out;
}

}  // namespace wheatstone
