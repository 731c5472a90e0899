#include "rendering/metrics/row_kernels.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include <opencv2/core/hal/intrin.hpp>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "core/image.h"
#include "rendering/metrics/pu21.h"

namespace wheatstone::detail {
namespace {

#if defined(__x86_64__)
template <auto kBody, class... Args>
[[gnu::target("avx2")]] void on_avx2(Args... args) {
  kBody(args...);
}
template <auto kBody, class... Args>
[[gnu::target("avx512f,prefer-vector-width=512")]] void on_avx512(Args... args) {
  kBody(args...);
}
#endif

/// Runs an always-inlined loop, compiled once for each level.
template <auto kBody, class... Args>
void run(Simd simd, Args... args) {
  switch (simd) {
#if defined(__x86_64__)
    case Simd::kAvx512:
      return on_avx512<kBody>(args...);
    case Simd::kAvx2:
      return on_avx2<kBody>(args...);
#endif
    default:
      return kBody(args...);
  }
}

/// Bits of the largest finite float: as unsigned integers, the valid samples are those up to it.
/// (-0 is not, which costs that picture a closer look by whoever asked.)
constexpr std::uint32_t kLargestFinite = 0x7f7fffff;

[[gnu::always_inline]] inline void is_light(const float* samples, int count, bool* valid) {
  unsigned invalid = 0;
  for (int i = 0; i < count; ++i)
    invalid |= std::bit_cast<std::uint32_t>(samples[i]) > kLargestFinite ? 1U : 0U;
  *valid = invalid == 0;
}

constexpr auto kRed = static_cast<float>(kLuminanceWeights[0]),
               kGreen = static_cast<float>(kLuminanceWeights[1]),
               kBlue = static_cast<float>(kLuminanceWeights[2]);

/// Pixels from `first` on; returns whether their samples are valid. Compilers split interleaved
/// colours badly, so this one loop is written with vectors.
bool luminance_portable(const float* rgb, int first, int count, float* out) {
  int i = first;
  for (; i + 4 <= count; i += 4) {
    cv::v_float32x4 r, g, b;
    cv::v_load_deinterleave(rgb + 3 * i, r, g, b);
    cv::v_store(out + i, r * cv::v_setall_f32(kRed) + g * cv::v_setall_f32(kGreen) +
                             b * cv::v_setall_f32(kBlue));
  }
  for (; i < count; ++i)
    out[i] = kRed * rgb[3 * i] + kGreen * rgb[3 * i + 1] + kBlue * rgb[3 * i + 2];
  bool valid = true;
  is_light(rgb + 3 * first, 3 * (count - first), &valid);
  return valid;
}

#if defined(__x86_64__)
/// For 48 interleaved samples in three registers: where lane i of one colour lies, first among the
/// 32 samples of the first two, then among the result of that and the third.
struct ColourLanes {
  alignas(64) std::array<std::int32_t, 16> in_first_two{}, in_all{};
  constexpr explicit ColourLanes(int colour) {
    for (int i = 0; i < 16; ++i) {
      const int at = 3 * i + colour;
      in_first_two[i] = at < 32 ? at : 0;
      in_all[i] = at < 32 ? i : 16 + at - 32;
    }
  }
};
constexpr std::array<ColourLanes, 3> kColourLanes = {ColourLanes(0), ColourLanes(1),
                                                     ColourLanes(2)};

[[gnu::target("avx512f")]] bool luminance_avx512(const float* rgb, int count, float* out) {
  __m512i first_two[3], all[3];
  for (int k = 0; k < 3; ++k) {
    first_two[k] = _mm512_load_si512(kColourLanes[k].in_first_two.data());
    all[k] = _mm512_load_si512(kColourLanes[k].in_all.data());
  }
  const __m512 red = _mm512_set1_ps(kRed), green = _mm512_set1_ps(kGreen),
               blue = _mm512_set1_ps(kBlue);
  __mmask16 invalid = 0;
  int i = 0;
  for (; i + 16 <= count; i += 16) {
    __m512 samples[3], colour[3];
    for (int k = 0; k < 3; ++k) {
      samples[k] = _mm512_loadu_ps(rgb + 3 * i + 16 * k);
      invalid |= _mm512_cmpgt_epu32_mask(_mm512_castps_si512(samples[k]),
                                         _mm512_set1_epi32(kLargestFinite));
    }
    for (int k = 0; k < 3; ++k)
      colour[k] = _mm512_permutex2var_ps(
          _mm512_permutex2var_ps(samples[0], first_two[k], samples[1]), all[k], samples[2]);
    const __m512 red_green =
        _mm512_add_ps(_mm512_mul_ps(red, colour[0]), _mm512_mul_ps(green, colour[1]));
    _mm512_storeu_ps(out + i, _mm512_add_ps(red_green, _mm512_mul_ps(blue, colour[2])));
  }
  return luminance_portable(rgb, i, count, out) && invalid == 0;
}
#endif

struct Moments {
  float mean, square;
};

/// Windowed mean and mean square of eleven values v(0)..v(10) about `origin`.
template <class Value>
[[gnu::always_inline]] inline Moments windowed(const float* tap, float origin, Value v) {
  const float centre = v(5) - origin;
  Moments out{tap[0] * centre, tap[0] * (centre * centre)};
  for (int k = 1; k <= SsimWindow::kRadius; ++k) {
    const float a = v(5 - k) - origin, b = v(5 + k) - origin;
    out.mean += tap[k] * (a + b);
    out.square += tap[k] * (a * a + b * b);
  }
  return out;
}

template <class Value>
[[gnu::always_inline]] inline float windowed_mean(const float* tap, Value v) {
  float sum = tap[0] * v(5);
  for (int k = 1; k <= SsimWindow::kRadius; ++k) sum += tap[k] * (v(5 - k) + v(5 + k));
  return sum;
}

[[gnu::always_inline]] inline void columns(const float* tap, const float* const* rows_s,
                                           const float* const* rows_d, int count,
                                           float* __restrict mean_s, float* __restrict variance_s,
                                           float* __restrict mean_d, float* __restrict square_d) {
  const float* s[SsimWindow::kTaps];
  const float* d[SsimWindow::kTaps];
  for (int k = 0; k < SsimWindow::kTaps; ++k) s[k] = rows_s[k], d[k] = rows_d[k];
#pragma GCC ivdep
  for (int i = 0; i < count; ++i) {
    const Moments m = windowed(tap, s[5][i], [&](int k) { return s[k][i]; });
    mean_s[i] = m.mean + s[5][i];
    variance_s[i] = m.square - m.mean * m.mean;
  }
#pragma GCC ivdep
  for (int i = 0; i < count; ++i) {
    const Moments m = windowed(tap, 0, [&](int k) { return d[k][i]; });
    mean_d[i] = m.mean;
    square_d[i] = m.square;
  }
}

[[gnu::always_inline]] inline void row(const float* tap, const float* mean_s,
                                       const float* variance_s, const float* mean_d,
                                       const float* square_d, int count, float* __restrict ssim,
                                       float* __restrict contrast_structure) {
  constexpr auto kC1 = static_cast<float>((0.01 * kPu21Peak) * (0.01 * kPu21Peak)),
                 kC2 = static_cast<float>((0.03 * kPu21Peak) * (0.03 * kPu21Peak));
#pragma GCC ivdep
  for (int i = 0; i < count; ++i) {
    const float origin = mean_s[i + 5];
    const Moments s = windowed(tap, origin, [&](int k) { return mean_s[i + k]; });
    const float within = windowed_mean(tap, [&](int k) { return variance_s[i + k]; });
    const float mean = s.mean + origin;
    const float variance = s.square - s.mean * s.mean + within;
    const float mean_difference = windowed_mean(tap, [&](int k) { return mean_d[i + k]; });
    const float difference2 = mean_difference * mean_difference;
    const float variance_difference =
        windowed_mean(tap, [&](int k) { return square_d[i + k]; }) - difference2;
    const float l = 0.5F * (mean * mean + difference2) + kC1;
    const float c = 0.5F * (variance + variance_difference) + kC2;
    const float reciprocal = 1 / (l * c);
    const float agreement = 1 - variance_difference * l * reciprocal;
    contrast_structure[i] = agreement;
    ssim[i] = agreement * (1 - difference2 * c * reciprocal);
  }
}

[[gnu::always_inline]] inline void sum_and_difference(const float* a, const float* b, int count,
                                                      float* __restrict sum,
                                                      float* __restrict difference) {
#pragma GCC ivdep
  for (int i = 0; i < count; ++i) {
    sum[i] = a[i] + b[i];
    difference[i] = a[i] - b[i];
  }
}

[[gnu::always_inline]] inline void accumulate(const float* values, const float* weights, int count,
                                              double* __restrict sums) {
  if (weights)
    for (int i = 0; i < count; ++i) sums[i] += double{weights[i]} * double{values[i]};
  else
    for (int i = 0; i < count; ++i) sums[i] += double{values[i]};
}

[[gnu::always_inline]] inline void accumulate_squares(const float* a, const float* b, int count,
                                                      double* __restrict sums) {
  for (int i = 0; i < count; ++i) {
    const double difference = double{a[i]} - double{b[i]};
    sums[i] += difference * difference;
  }
}

}  // namespace

SsimWindow::SsimWindow() {
  std::array<double, kRadius + 1> weight{};
  double sum = 0;
  for (int k = 0; k <= kRadius; ++k) {
    weight[k] = std::exp(-k * k / (2 * 1.5 * 1.5));
    sum += k == 0 ? weight[k] : 2 * weight[k];
  }
  for (int k = 0; k <= kRadius; ++k) tap[k] = static_cast<float>(weight[k] / sum);
}

bool luminance_row(const float* rgb, int count, float* luminance_cd_m2, Simd simd) {
#if defined(__x86_64__)
  if (simd == Simd::kAvx512) return luminance_avx512(rgb, count, luminance_cd_m2);
#else
  (void)simd;
#endif
  return luminance_portable(rgb, 0, count, luminance_cd_m2);
}

void sum_and_difference_row(const float* a, const float* b, int count, float* sum,
                            float* difference, Simd simd) {
  run<sum_and_difference>(simd, a, b, count, sum, difference);
}

void window_columns(const SsimWindow& window, const float* const* rows_s,
                    const float* const* rows_d, int count, MomentRows out, Simd simd) {
  run<columns>(simd, window.tap.data(), rows_s, rows_d, count, out.mean_s, out.variance_s,
               out.mean_d, out.square_d);
}

void window_row(const SsimWindow& window, MomentRows columns, int count, float* ssim,
                float* contrast_structure, Simd simd) {
  run<row>(simd, window.tap.data(), static_cast<const float*>(columns.mean_s),
           static_cast<const float*>(columns.variance_s), static_cast<const float*>(columns.mean_d),
           static_cast<const float*>(columns.square_d), count, ssim, contrast_structure);
}

void accumulate_row(const float* values, const float* weights, int count, double* sums, Simd simd) {
  run<accumulate>(simd, values, weights, count, sums);
}

void accumulate_squared_difference(const float* a, const float* b, int count, double* sums,
                                   Simd simd) {
  run<accumulate_squares>(simd, a, b, count, sums);
}

}  // namespace wheatstone::detail
