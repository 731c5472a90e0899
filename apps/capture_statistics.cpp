#include "apps/capture_statistics.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/exr.h"
#include "core/png.h"

namespace wheatstone::apps {
namespace {

constexpr int kBins = 128;

double variance_dn2(const CameraProfile& camera, int colour, double signal_dn) {
  const double k = camera.dn_per_electron[static_cast<std::size_t>(colour)];
  return std::max(signal_dn, 0.0) * k +
         (camera.read_noise_e * camera.read_noise_e + camera.adc_noise * camera.adc_noise) * k * k;
}

FrameStatistics frame_statistics(const MosaicImage& frame, const CameraProfile& camera) {
  FrameStatistics out;
  const double range = camera.white_dn - camera.black_dn;
  out.bin_dn = range / kBins;
  out.histogram.assign(kBins, 0.0);
  const double one = 1.0 / static_cast<double>(frame.dn.total());
  for (int y = 0; y < frame.height(); ++y)
    for (int x = 0; x < frame.width(); ++x) {
      const double signal = frame.dn(y, x) - camera.black_dn;
      if (frame.dn(y, x) >= camera.white_dn) out.saturated += one;
      const int colour = bayer_colour(frame.pattern, y, x);
      if (signal < 2 * std::sqrt(variance_dn2(camera, colour, signal))) out.in_the_noise += one;
      const int bin = static_cast<int>(signal / out.bin_dn);
      out.histogram[static_cast<std::size_t>(std::clamp(bin, 0, kBins - 1))] += one;
    }
  return out;
}

/// Two measurements of the same light differ by their noise: |x_a / t_a - x_b / t_b| has the median
/// 0.6745 times its standard deviation.
std::vector<NoiseLevel> noise_levels(const MosaicImage& shorter, double t_short,
                                     const MosaicImage& longer, double t_long,
                                     const CameraProfile& camera) {
  constexpr int kLevels = 24;
  constexpr std::size_t kFewest = 200;
  const double range = camera.white_dn - camera.black_dn;
  std::vector<std::vector<double>> ratios(kLevels);
  std::vector<double> sums(kLevels, 0.0);
  for (int y = 0; y < longer.height(); ++y)
    for (int x = 0; x < longer.width(); ++x) {
      if (longer.dn(y, x) >= camera.white_dn || shorter.dn(y, x) >= camera.white_dn) continue;
      const int colour = bayer_colour(longer.pattern, y, x);
      const double a = shorter.dn(y, x) - camera.black_dn, b = longer.dn(y, x) - camera.black_dn;
      const double light = (a + b) / (t_short + t_long);  // the best estimate of both, DN/s
      if (light * t_long < 1) continue;
      const double sigma =
          std::sqrt(variance_dn2(camera, colour, light * t_short) / (t_short * t_short) +
                    variance_dn2(camera, colour, light * t_long) / (t_long * t_long));
      const auto level = static_cast<std::size_t>(
          std::clamp(kLevels * std::log(light * t_long) / std::log(range), 0.0, kLevels - 1.0));
      ratios[level].push_back(std::abs(a / t_short - b / t_long) / sigma);
      sums[level] += light * t_long;
    }
  std::vector<NoiseLevel> out;
  for (std::size_t level = 0; level < ratios.size(); ++level) {
    std::vector<double>& r = ratios[level];
    if (r.size() < kFewest) continue;
    const auto middle = r.begin() + static_cast<std::ptrdiff_t>(r.size() / 2);
    std::nth_element(r.begin(), middle, r.end());
    const double n = static_cast<double>(r.size()), ratio = *middle / 0.6745;
    // The median of |N(0, 1)| varies by 1 / (2 p sqrt(n)), where p = 0.6356 is its density there.
    out.push_back({sums[level] / n, ratio, 1.166 * ratio / std::sqrt(n)});
  }
  return out;
}

}  // namespace

double least_signal_dn(const CameraProfile& camera) {
  const double k = camera.dn_per_electron[1];
  const double electronic2 =
      camera.read_noise_e * camera.read_noise_e + camera.adc_noise * camera.adc_noise;
  return 2 * k * (1 + std::sqrt(1 + electronic2));
}

ViewStatistics view_statistics(const Dataset& dataset, const CapturedView& view,
                               const CameraProfile& camera) {
  ViewStatistics out;
  out.name = view.name;
  std::vector<std::pair<double, MosaicImage>> frames;
  for (const ExposureRecord& e : view.exposures) {
    frames.emplace_back(e.exposure_s, read_mosaic_png(dataset.file(e.file), camera.pattern));
    const MosaicImage& frame = frames.back().second;
    if (frame.dn.size() != frames.front().second.dn.size())
      throw FileError(dataset.file(e.file), "has another size than the view's first frame",
                      "capture the view again");
    out.frames.push_back(frame_statistics(frame, camera));
  }
  std::sort(frames.begin(), frames.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 1; i < frames.size(); ++i)
    for (const NoiseLevel& level : noise_levels(frames[i - 1].second, frames[i - 1].first,
                                                frames[i].second, frames[i].first, camera))
      out.noise.push_back(level);
  std::sort(out.noise.begin(), out.noise.end(),
            [](const NoiseLevel& a, const NoiseLevel& b) { return a.signal_dn < b.signal_dn; });
  return out;
}

MergedTrust merged_trust(const std::filesystem::path& file) {
  const std::map<std::string, ScalarImage> channels = read_exr_views(file).at(0).channels;
  const auto saturated = channels.find("mask.saturated"), sigma = channels.find("sigma.Y");
  if (saturated == channels.end())
    throw FileError(file, "has no layer mask.saturated", "merge the view again");
  MergedTrust out{saturated->second.pixels > 0.5F, {}};
  if (sigma == channels.end()) return out;
  const ScalarImage light = luminance_cd_m2(read_exr(file));
  out.deviation_percent = ScalarImage(light.width(), light.height(), 100);
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x)
      if (light.pixels(y, x) > 0)
        out.deviation_percent.pixels(y, x) = 100 * sigma->second.pixels(y, x) / light.pixels(y, x);
  return out;
}

}  // namespace wheatstone::apps
