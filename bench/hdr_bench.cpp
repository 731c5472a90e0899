// Speed of the way from raw mosaics to a merged picture, 7360 x 4912 px, and what demosaicing
// gains.
//
// Stream copy: every byte of the five frames is read once (summed) and every byte of the outputs is
// written once (memset), in parallel bands like the merge. Both sides use their memory again, so
// that neither pays for fresh pages.

#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#ifdef WHEATSTONE_HAS_OPENCV_PHOTO
#include <opencv2/photo.hpp>
#endif

#include "bench/harness.h"
#include "capture/demosaic.h"
#include "capture/merge.h"
#include "capture/merged_exr.h"
#include "core/exr.h"
#include "core/random.h"

namespace wheatstone {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 7360, kHeight = 4912;
constexpr double kRatio = 4;  // between neighbouring exposures

/// A smooth scene of 1000 : 1 with small lights and the noise of its photons; the longest frame is
/// saturated in about a third of its area, as lab stacks are.
const std::vector<RawExposure>& stack() {
  static const std::vector<RawExposure> frames = [] {
    std::vector<RawExposure> out;
    for (int i = 0; i < 5; ++i)
      out.push_back({{cv::Mat1w(kHeight, kWidth), BayerPattern::kRggb},
                     Duration::of(std::pow(kRatio, i) / 1000)});
    cv::parallel_for_(cv::Range(0, kHeight), [&](const cv::Range& rows) {
      for (int r = rows.start; r < rows.end; ++r) {
        RandomStream random(3, static_cast<std::uint64_t>(r));
        for (int c = 0; c < kWidth; ++c) {
          const double light = 60 * std::exp(3.4 * std::sin(r / 700.0) * std::cos(c / 900.0) +
                                             0.2 * std::sin(c / 9.0));
          for (int i = 0; i < 5; ++i) {
            const double dn = light * std::pow(kRatio, i) / 16;
            const double noise = (random.uniform() + random.uniform() - 1) * std::sqrt(dn + 5);
            out[static_cast<std::size_t>(i)].frame.dn(r, c) =
                static_cast<std::uint16_t>(std::clamp(512 + dn + noise, 0.0, 16383.0));
          }
        }
      }
    });
    return out;
  }();
  return frames;
}

MergeOptions options(bool with_noise) {
  MergeOptions o;
  o.black_dn.fill(512);
  o.saturation_dn = 16383;
  if (with_noise) o.noise = SensorNoise{{0.422044, 0.384277, 0.388967}, 0.705127, 3.02845};
  return o;
}

void stream_copy(benchmark::State& state, std::size_t bytes_per_pixel) {
  const std::vector<RawExposure>& frames = stack();
  std::vector<unsigned char> out(bytes_per_pixel * kWidth * kHeight, 1);
  const std::size_t row_bytes = bytes_per_pixel * kWidth;
  for (auto _ : state) {
    cv::parallel_for_(cv::Range(0, kHeight), [&](const cv::Range& rows) {
      std::uint64_t sum = 0;
      for (int r = rows.start; r < rows.end; ++r) {
        for (const RawExposure& e : frames) {
          const auto* words = reinterpret_cast<const std::uint64_t*>(e.frame.dn.ptr(r));
          sum = std::accumulate(words, words + kWidth / 4, sum);
        }
        std::memset(out.data() + static_cast<std::size_t>(r) * row_bytes, static_cast<int>(sum & 1),
                    row_bytes);
      }
      benchmark::DoNotOptimize(sum);
    });
    benchmark::ClobberMemory();
  }
}
void BM_stream_copy_with_sigma(benchmark::State& state) {
  stream_copy(state, 4 + 4 + 1);
}
void BM_stream_copy(benchmark::State& state) {
  stream_copy(state, 4 + 1);
}

void merge_stack(benchmark::State& state, bool with_noise) {
  const std::vector<RawExposure>& frames = stack();
  MergedMosaic merged;
  merge_exposures(frames, options(with_noise), merged);
  for (auto _ : state) {
    merge_exposures(frames, options(with_noise), merged);
    benchmark::ClobberMemory();
  }
}
void BM_merge_with_sigma(benchmark::State& state) {
  merge_stack(state, true);
}
void BM_merge(benchmark::State& state) {
  merge_stack(state, false);
}
BENCHMARK(BM_stream_copy)->UseRealTime();
BENCHMARK(BM_merge)->UseRealTime();
BENCHMARK(BM_stream_copy_with_sigma)->UseRealTime();
BENCHMARK(BM_merge_with_sigma)->UseRealTime();
WHEATSTONE_RATIO("merge_over_stream_copy", "BM_merge/real_time", "BM_stream_copy/real_time");
WHEATSTONE_RATIO("merge_with_sigma_over_stream_copy", "BM_merge_with_sigma/real_time",
                 "BM_stream_copy_with_sigma/real_time");

#ifdef WHEATSTONE_HAS_OPENCV_PHOTO
/// OpenCV merges 8-bit colour frames; these are an eighth of the width, to end in a minute.
void BM_opencv_merge_debevec_one_eighth(benchmark::State& state) {
  std::vector<cv::Mat> frames;
  std::vector<float> times;
  for (const RawExposure& e : stack()) {
    cv::Mat1b grey;
    e.frame.dn.colRange(0, kWidth / 8).convertTo(grey, CV_8U, 255.0 / 16383);
    cv::Mat colour;
    cv::cvtColor(grey, colour, cv::COLOR_GRAY2BGR);
    frames.push_back(colour);
    times.push_back(static_cast<float>(e.exposure.value()));
  }
  const auto merge = cv::createMergeDebevec();
  cv::Mat out;
  for (auto _ : state) merge->process(frames, out, times);
}
BENCHMARK(BM_opencv_merge_debevec_one_eighth)->UseRealTime()->Unit(benchmark::kMillisecond);
WHEATSTONE_RATIO("opencv_debevec_of_an_eighth_over_merge",
                 "BM_opencv_merge_debevec_one_eighth/real_time", "BM_merge/real_time");
#endif

const MergedMosaic& merged() {
  static const MergedMosaic m = merge_exposures(stack(), options(true));
  return m;
}

void BM_demosaic(benchmark::State& state) {
  cv::Mat3f out;
  demosaic_rows(merged().mosaic, {0, kHeight}, out);
  for (auto _ : state) demosaic_rows(merged().mosaic, {0, kHeight}, out);
}
void BM_opencv_demosaic_ea(benchmark::State& state) {
  cv::Mat out;
  cv::demosaicing(stack()[2].frame.dn, out, cv::COLOR_BayerBG2RGB_EA);
  for (auto _ : state) cv::demosaicing(stack()[2].frame.dn, out, cv::COLOR_BayerBG2RGB_EA);
}
BENCHMARK(BM_demosaic)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(BM_opencv_demosaic_ea)->UseRealTime()->Unit(benchmark::kMillisecond);
WHEATSTONE_RATIO("demosaic_over_opencv_ea", "BM_demosaic/real_time",
                 "BM_opencv_demosaic_ea/real_time");

CameraProfile camera() {
  CameraProfile p;
  p.black_dn = 512;
  p.white_dn = 16383;
  p.dn_per_cd_m2_s = 950;
  p.camera_from_bt709 << 0.88, 0.10, 0.02, 0.04, 0.90, 0.06, 0.01, 0.09, 0.90;
  p.dn_per_electron = {0.422044, 0.384277, 0.388967};
  p.read_noise_e = 0.705127;
  p.adc_noise = 3.02845;
  return p;
}

const fs::path& scratch_file() {
  static const fs::path file =
      fs::temp_directory_path() / ("wheatstone_bench_" + std::to_string(::getpid()) + ".exr");
  return file;
}

/// Five mosaics in memory to light with deviations and masks in an OpenEXR file.
void BM_view_to_exr(benchmark::State& state) {
  for (auto _ : state) {
    const MergedMosaic m = merge_exposures(stack(), merge_options(camera()));
    write_merged_light_exr(scratch_file(), m, camera());
  }
  fs::remove(scratch_file());
}
/// The same channels of the same picture, ready made in memory, only written.
void BM_exr_write_alone(benchmark::State& state) {
  write_merged_light_exr(scratch_file(), merged(), camera());
  const ExrView view = read_exr_views(scratch_file())[0];
  ExrPicture picture{merged().flags.size(), {}, true, ExrCompression::kPiz};
  std::vector<cv::Mat1f> planes;
  for (const auto& [name, image] : view.channels) {
    const bool is_float = name == "sigma.Y";
    picture.channels.push_back({name, is_float ? ExrPrecision::kFloat : ExrPrecision::kHalf});
    planes.push_back(image.pixels);
  }
  for (auto _ : state)
    write_exr_rows(scratch_file(), picture, [&](cv::Range rows, std::span<cv::Mat1f> bands) {
      for (std::size_t i = 0; i < bands.size(); ++i) planes[i].rowRange(rows).copyTo(bands[i]);
    });
  fs::remove(scratch_file());
}
BENCHMARK(BM_view_to_exr)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(BM_exr_write_alone)->UseRealTime()->Unit(benchmark::kMillisecond);
WHEATSTONE_RATIO("view_to_exr_over_write_alone", "BM_view_to_exr/real_time",
                 "BM_exr_write_alone/real_time");

/// Colour peak signal-to-noise ratio over the three colours, peak 65535, 8 px inside.
double cpsnr_db(const cv::Mat& a, const cv::Mat3f& b) {
  const cv::Rect inside(8, 8, b.cols - 16, b.rows - 16);
  cv::Mat3f x;
  a(inside).convertTo(x, CV_32F);
  const double squares = cv::norm(x, b(inside), cv::NORM_L2SQR);
  return 10 * std::log10(65535.0 * 65535.0 * 3 * inside.area() / squares);
}

/// Photographs made to mosaics again: what DDFAPD gains over OpenCV's edge-aware method.
void BM_cpsnr_gain_on_photographs(benchmark::State& state) {
  const char* set = std::getenv("WHEATSTONE_SHARED");
  const fs::path data = fs::path(set != nullptr ? set : WHEATSTONE_DEFAULT_SHARED) / "data";
  double sum_db = 0, least_db = 1e9;
  int count = 0;
  for (auto _ : state) {
    if (!fs::exists(data)) {
      state.SkipWithError("the photographs are not there");
      break;
    }
    for (const auto& entry : fs::recursive_directory_iterator(data)) {
      const std::string extension = entry.path().extension();
      if (extension != ".jpg" && extension != ".png") continue;
      const cv::Mat photo = cv::imread(entry.path(), cv::IMREAD_COLOR);  // 8 bit, B, G, R
      if (photo.empty() || photo.cols < 200 || photo.rows < 200) continue;
      cv::Mat1w mosaic(photo.size());
      cv::Mat3f truth(photo.size());
      for (int r = 0; r < photo.rows; ++r)
        for (int c = 0; c < photo.cols; ++c) {
          for (int k = 0; k < 3; ++k) truth(r, c)[k] = 257.0f * photo.at<cv::Vec3b>(r, c)[2 - k];
          mosaic(r, c) = static_cast<ushort>(truth(r, c)[bayer_colour(BayerPattern::kRggb, r, c)]);
        }
      if (cv::norm(truth, cv::NORM_INF) == 0) continue;
      LinearMosaic linear{{}, BayerPattern::kRggb};
      mosaic.convertTo(linear.values, CV_32F);
      cv::Mat edge_aware;
      cv::demosaicing(mosaic, edge_aware, cv::COLOR_BayerBG2RGB_EA);
      const double gain_db = cpsnr_db(demosaic(linear), truth) - cpsnr_db(edge_aware, truth);
      if (!std::isfinite(gain_db)) continue;
      sum_db += gain_db;
      least_db = std::min(least_db, gain_db);
      ++count;
    }
  }
  if (count == 0) return;
  bench::add_figure("photographs", count);
  bench::add_figure("cpsnr_gain_over_opencv_ea_mean_db", sum_db / count);
  bench::add_figure("cpsnr_gain_over_opencv_ea_least_db", least_db);
}
BENCHMARK(BM_cpsnr_gain_on_photographs)->Iterations(1)->Repetitions(1);

}  // namespace
}  // namespace wheatstone
