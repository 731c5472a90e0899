// Speed of PU21-SSIM on a pair of 2160x1440 pictures beside one OpenCV GaussianBlur of one float
// plane of that size (11x11, sigma 1.5), and beside SSIM written with that function. Both sides get
// the same number of threads: one, then all.

#include <tbb/global_control.h>

#include <opencv2/imgproc.hpp>
#include <thread>

#include "bench/harness.h"
#include "core/random.h"
#include "rendering/metrics/pu21.h"
#include "rendering/metrics/ssim.h"

namespace wheatstone {
namespace {

constexpr int kWidth = 2160, kHeight = 1440;

/// Smooth light over four decades with noise, and the same with a little more noise.
struct Pair {
  RgbImage test{kWidth, kHeight}, reference{kWidth, kHeight};
  Pair() {
    RandomStream random(1, 0);
    for (int r = 0; r < kHeight; ++r)
      for (int c = 0; c < kWidth; ++c)
        for (int k = 0; k < 3; ++k) {
          const double light = std::exp(3.5 + 3.5 * std::sin(0.01 * r + k) * std::cos(0.013 * c));
          reference.pixels(r, c)[k] = static_cast<float>(light * (1 + 0.1 * random.uniform()));
          test.pixels(r, c)[k] =
              static_cast<float>(reference.pixels(r, c)[k] * (1 + 0.05 * random.uniform()));
        }
  }
};
const Pair& pair() {  // made once, before any clock runs
  static const Pair p;
  return p;
}

/// OpenCV's and TBB's threads for the length of a case.
class Threads {
 public:
  explicit Threads(int count)
      : control_(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(count)) {
    cv::setNumThreads(count);
  }

 private:
  tbb::global_control control_;
};

cv::Mat1f blurred(const cv::Mat1f& plane) {
  cv::Mat1f out;
  cv::GaussianBlur(plane, out, {11, 11}, 1.5, 1.5, cv::BORDER_REPLICATE);
  return out;
}

void BM_gaussian_blur(benchmark::State& state) {
  const Threads threads(static_cast<int>(state.range(0)));
  const cv::Mat1f plane = luminance_cd_m2(pair().reference).pixels;
  cv::Mat1f out = blurred(plane);  // its memory is not part of the comparison
  for (auto _ : state) {
    cv::GaussianBlur(plane, out, {11, 11}, 1.5, 1.5, cv::BORDER_REPLICATE);
    benchmark::DoNotOptimize(out.data);
  }
}

void BM_pu21_ssim(benchmark::State& state) {
  const Threads threads(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(pu21_ssim_luminance(pair().test, pair().reference));
}

void BM_pu21_ms_ssim(benchmark::State& state) {
  const Threads threads(static_cast<int>(state.range(0)));
  pair();
  for (auto _ : state)
    benchmark::DoNotOptimize(pu21_ms_ssim_luminance(pair().test, pair().reference));
}

void BM_pu21_psnr_rgb(benchmark::State& state) {
  const Threads threads(static_cast<int>(state.range(0)));
  pair();
  for (auto _ : state) benchmark::DoNotOptimize(pu21_psnr_rgb(pair().test, pair().reference));
}

/// The usual way to write it: whole planes, five blurs.
void BM_plain_ssim(benchmark::State& state) {
  const Threads threads(static_cast<int>(state.range(0)));
  pair();
  for (auto _ : state) {
    cv::Mat1f x = luminance_cd_m2(pair().test).pixels, y = luminance_cd_m2(pair().reference).pixels;
    for (cv::Mat1f* plane : {&x, &y})
      for (float& v : *plane) v = static_cast<float>(pu21_encode(v));
    const double c1 = 2.56 * 2.56, c2 = 7.68 * 7.68;
    const cv::Mat1f mx = blurred(x), my = blurred(y);
    const cv::Mat1f sxx = blurred(x.mul(x)) - mx.mul(mx), syy = blurred(y.mul(y)) - my.mul(my),
                    sxy = blurred(x.mul(y)) - mx.mul(my);
    const cv::Mat1f over = (2 * mx.mul(my) + c1).mul(2 * sxy + c2),
                    under = (mx.mul(mx) + my.mul(my) + c1).mul(sxx + syy + c2);
    benchmark::DoNotOptimize(cv::mean(over / under)[0]);
  }
}

const int kAll = static_cast<int>(std::thread::hardware_concurrency());
BENCHMARK(BM_gaussian_blur)->Name("gaussian_blur")->Arg(1)->UseRealTime();
BENCHMARK(BM_pu21_ssim)->Name("pu21_ssim")->Arg(1)->UseRealTime();
BENCHMARK(BM_gaussian_blur)->Name("gaussian_blur_all_threads")->Arg(kAll)->UseRealTime();
BENCHMARK(BM_pu21_ssim)->Name("pu21_ssim_all_threads")->Arg(kAll)->UseRealTime();
BENCHMARK(BM_plain_ssim)->Name("plain_ssim")->Arg(1)->UseRealTime();
BENCHMARK(BM_pu21_ms_ssim)->Name("pu21_ms_ssim")->Arg(1)->UseRealTime();
BENCHMARK(BM_pu21_psnr_rgb)->Name("pu21_psnr_rgb")->Arg(1)->UseRealTime();

std::string all(const std::string& name) {
  return name + "_all_threads/" + std::to_string(kAll) + "/real_time";
}
WHEATSTONE_RATIO("ssim_in_gaussian_blurs_one_thread", "pu21_ssim/1/real_time",
                 "gaussian_blur/1/real_time");
WHEATSTONE_RATIO("ssim_in_gaussian_blurs_all_threads", all("pu21_ssim"), all("gaussian_blur"));
WHEATSTONE_RATIO("ms_ssim_in_gaussian_blurs_one_thread", "pu21_ms_ssim/1/real_time",
                 "gaussian_blur/1/real_time");
WHEATSTONE_RATIO("plain_ssim_over_ssim_one_thread", "plain_ssim/1/real_time",
                 "pu21_ssim/1/real_time");

}  // namespace
}  // namespace wheatstone
