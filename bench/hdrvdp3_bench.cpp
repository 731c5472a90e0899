// Speed and peak memory of HDR-VDP-3 on a pair of 2160x1440 pixels, and its costly stages beside
// the straightforward way to do them: complex Fourier transforms of the image at twice its size
// for glare and adaptation, direct correlation with the pyramid's filters.

#include <malloc.h>

#include <cmath>
#include <ctime>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <string>

#include "bench/harness.h"
#include "core/error.h"
#include "core/random.h"
#include "rendering/metrics/hdrvdp3.h"
#include "rendering/metrics/hdrvdp3/eye_optics.h"
#include "rendering/metrics/hdrvdp3/gaussian_blur.h"
#include "rendering/metrics/hdrvdp3/steerable_pyramid.h"

namespace wheatstone {
namespace {

constexpr int kWidth = 2160, kHeight = 1440;
constexpr double kPixelsPerDegree = 45, kAdaptationSigmaPx = 7.445;

/// Structure of all sizes over three decades of light.
RgbImage reference_image() {
  RgbImage out(kWidth, kHeight);
  RandomStream random(1, 0);
  for (cv::Vec3f& p : out.pixels) {
    const double v = random.normal();
    for (int k = 0; k < 3; ++k) p[k] = static_cast<float>(20 * std::exp(v + 0.2 * k));
  }
  cv::Mat3f coarse;
  cv::GaussianBlur(out.pixels, coarse, {0, 0}, 12);
  cv::GaussianBlur(out.pixels, out.pixels, {0, 0}, 1.5);
  out.pixels = out.pixels.mul(coarse) / 30;
  return out;
}

RgbImage test_image() {
  RgbImage out = reference_image();
  cv::GaussianBlur(out.pixels, out.pixels, {0, 0}, 1);
  return out;
}

cv::Mat1d plane() {
  static const RgbImage image = reference_image();
  cv::Mat1f green;
  cv::extractChannel(image.pixels, green, 1);
  cv::Mat1d out;
  green.convertTo(out, CV_64F);
  return out;
}

/// Largest resident memory since forget_peak(), MiB (Linux).
void forget_peak() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5";
}
double peak_memory_mib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024;
  throw InternalError("/proc/self/status does not name VmHWM");
}

void BM_hdr_vdp3(benchmark::State& state) {
  const RgbImage test = test_image(), reference = reference_image();
  HdrVdp3Options options;
  options.pixels_per_degree = kPixelsPerDegree;
  static double least_cpu_s = 1e9, most_mib = 0;
  for (auto _ : state) {
    forget_peak();
    const std::clock_t start = std::clock();
    benchmark::DoNotOptimize(hdr_vdp3(test, reference, options).q_jod);
    least_cpu_s = std::min(least_cpu_s, double(std::clock() - start) / CLOCKS_PER_SEC);
    most_mib = std::max(most_mib, peak_memory_mib());
  }
  // Processor time says what a machine needs that does nothing else.
  bench::add_figure("hdr_vdp3_least_cpu_s", least_cpu_s);
  bench::add_figure("hdr_vdp3_peak_memory_mib", most_mib);
}
BENCHMARK(BM_hdr_vdp3)->Unit(benchmark::kMillisecond);

void BM_glare(benchmark::State& state) {
  const EyeGlare glare({kWidth, kHeight}, kPixelsPerDegree);
  cv::Mat1d image = plane();
  for (auto _ : state) glare.apply(image);
}
BENCHMARK(BM_glare)->Unit(benchmark::kMillisecond);

/// Complex transform of the image continued to twice its size; the gain is there beforehand.
void filter_by_fourier(cv::Mat1d& image, int border, const cv::Mat1d& gain) {
  cv::Mat twice, spectrum;
  cv::copyMakeBorder(image, twice, 0, image.rows, 0, image.cols, border);
  cv::dft(twice, spectrum, cv::DFT_COMPLEX_OUTPUT);
  for (int r = 0; r < gain.rows; ++r)
    for (int c = 0; c < gain.cols; ++c) spectrum.at<cv::Vec2d>(r, c) *= gain(r, c);
  cv::dft(spectrum, twice, cv::DFT_INVERSE | cv::DFT_SCALE | cv::DFT_REAL_OUTPUT);
  twice(cv::Rect({0, 0}, image.size())).copyTo(image);
}

template <class Gain>
cv::Mat1d fourier_gain(Gain gain) {
  const auto frequency = [](int k, int n) { return std::min(k, n - k) / static_cast<double>(n); };
  cv::Mat1d out(2 * kHeight, 2 * kWidth);
  for (int r = 0; r < out.rows; ++r)
    for (int c = 0; c < out.cols; ++c)
      out(r, c) = gain(std::hypot(frequency(r, out.rows), frequency(c, out.cols)));
  return out;
}

void BM_glare_by_fourier(benchmark::State& state) {
  const cv::Mat1d gain = fourier_gain([](double f) { return eye_mtf(f * kPixelsPerDegree); });
  cv::Mat1d image = plane();
  for (auto _ : state) filter_by_fourier(image, cv::BORDER_REFLECT, gain);
}
BENCHMARK(BM_glare_by_fourier)->Unit(benchmark::kMillisecond);

void BM_adaptation(benchmark::State& state) {
  cv::Mat1d image = plane();
  for (auto _ : state) gaussian_blur(image, kAdaptationSigmaPx, BlurBorder::kReplicate);
}
BENCHMARK(BM_adaptation)->Unit(benchmark::kMillisecond);

void BM_adaptation_by_fourier(benchmark::State& state) {
  const cv::Mat1d gain = fourier_gain([](double f) {
    const double w = 2 * M_PI * f * kAdaptationSigmaPx;
    return std::exp(-0.5 * w * w);
  });
  cv::Mat1d image = plane();
  for (auto _ : state) filter_by_fourier(image, cv::BORDER_REPLICATE, gain);
}
BENCHMARK(BM_adaptation_by_fourier)->Unit(benchmark::kMillisecond);

void BM_pyramid(benchmark::State& state) {
  const cv::Mat1d image = plane();
  for (auto _ : state) benchmark::DoNotOptimize(steerable_bands(image, 4).back().data);
}
BENCHMARK(BM_pyramid)->Unit(benchmark::kMillisecond);

/// The same filter sizes on the same images through cv::filter2D; the taps do not matter.
void BM_pyramid_by_correlation(benchmark::State& state) {
  const cv::Mat1d image = plane();
  const auto correlate = [](const cv::Mat1d& in, int side) {
    cv::Mat1d out;
    cv::filter2D(in, out, -1, cv::Mat1d(side, side, 0.01), {-1, -1}, 0, cv::BORDER_REFLECT_101);
    return out;
  };
  for (auto _ : state) {
    benchmark::DoNotOptimize(correlate(image, 9).data);
    cv::Mat1d low = correlate(image, 7);
    for (int level = 0; level < 4; ++level) {
      benchmark::DoNotOptimize(correlate(low, 9).data);
      cv::resize(correlate(low, 13), low, {}, 0.5, 0.5, cv::INTER_NEAREST);
    }
  }
}
BENCHMARK(BM_pyramid_by_correlation)->Unit(benchmark::kMillisecond);

WHEATSTONE_RATIO("glare_times_faster_than_fourier", "BM_glare_by_fourier", "BM_glare");
WHEATSTONE_RATIO("adaptation_times_faster_than_fourier", "BM_adaptation_by_fourier",
                 "BM_adaptation");
WHEATSTONE_RATIO("pyramid_times_faster_than_correlation", "BM_pyramid_by_correlation",
                 "BM_pyramid");

}  // namespace
}  // namespace wheatstone
