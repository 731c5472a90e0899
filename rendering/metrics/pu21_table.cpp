#include "rendering/metrics/pu21_table.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace wheatstone::detail {
namespace {

constexpr float kMin = static_cast<float>(kPu21MinCdM2), kMax = static_cast<float>(kPu21MaxCdM2);
constexpr float kLargest = std::numeric_limits<float>::max();
constexpr int kDegree = Pu21Table::kDegree;
constexpr std::int32_t kFirstBiasedExponent = 127 + Pu21Table::kLowestExponent;
constexpr std::int32_t kMantissa = 0x007fffff, kOne = 0x3f800000;  // the bits of 1.0f

/// Interpolates curve(2^exponent (1.5 + t)) at the Chebyshev points of [-0.5, 0.5]: divided
/// differences, then expanded to powers of t.
std::array<double, kDegree + 1> interpolate(Pu21Variant variant, int exponent) {
  constexpr int n = kDegree + 1;
  std::array<double, n> t{}, c{}, power{};
  for (int i = 0; i < n; ++i) {
    t[i] = 0.5 * std::cos(std::numbers::pi * (i + 0.5) / n);
    c[i] = pu21_curve(std::ldexp(1.5 + t[i], exponent), variant);
  }
  for (int j = 1; j < n; ++j)
    for (int i = n - 1; i >= j; --i) c[i] = (c[i] - c[i - 1]) / (t[i] - t[i - j]);
  for (int i = n - 1; i >= 0; --i) {  // power := power * (t - t_i) + c_i
    for (int k = n - 1; k > 0; --k) power[k] = power[k - 1] - t[i] * power[k];
    power[0] = c[i] - t[i] * power[0];
  }
  return power;
}

Pu21Table make_table(Pu21Variant variant) {
  Pu21Table table;
  for (int octave = 0; octave < Pu21Table::kOctaves; ++octave) {
    const auto power = interpolate(variant, octave + Pu21Table::kLowestExponent);
    for (int k = 0; k <= kDegree; ++k) table.coefficient[k][octave] = static_cast<float>(power[k]);
  }
  return table;
}

bool encode_portable(const Pu21Table& table, const float* in, std::size_t count, float* out) {
  bool valid = true;
  for (std::size_t i = 0; i < count; ++i) {
    valid &= in[i] >= 0 && in[i] <= kLargest;
    float y = in[i] > kMin ? in[i] : kMin;
    y = y < kMax ? y : kMax;
    const auto bits = std::bit_cast<std::int32_t>(y);
    const std::int32_t octave = (bits >> 23) - kFirstBiasedExponent;
    const float t = std::bit_cast<float>((bits & kMantissa) | kOne) - 1.5F;
    float v = table.coefficient[kDegree][octave];
    for (int k = kDegree - 1; k >= 0; --k) v = v * t + table.coefficient[k][octave];
    out[i] = v > 0 ? v : 0;
  }
  return valid;
}

#if defined(__x86_64__)

/// Column `octave` (0..23) of one row of the table, for eight values at once.
[[gnu::target("avx2"), gnu::always_inline]] inline __m256 look_up(const float* row,
                                                                  __m256i octave) {
  const __m256 bit_3 = _mm256_castsi256_ps(_mm256_slli_epi32(octave, 28));
  const __m256 bit_4 = _mm256_castsi256_ps(_mm256_slli_epi32(octave, 27));
  const __m256 below_8 = _mm256_permutevar8x32_ps(_mm256_load_ps(row), octave);
  const __m256 below_16 = _mm256_permutevar8x32_ps(_mm256_load_ps(row + 8), octave);
  const __m256 below_24 = _mm256_permutevar8x32_ps(_mm256_load_ps(row + 16), octave);
  return _mm256_blendv_ps(_mm256_blendv_ps(below_8, below_16, bit_3), below_24, bit_4);
}

[[gnu::target("avx2")]] bool encode_avx2(const Pu21Table& table, const float* in, std::size_t count,
                                         float* out) {
  __m256 valid = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
  std::size_t i = 0;
  for (; i + 8 <= count; i += 8) {
    __m256 y = _mm256_loadu_ps(in + i);
    valid = _mm256_and_ps(valid, _mm256_cmp_ps(y, _mm256_setzero_ps(), _CMP_GE_OQ));
    valid = _mm256_and_ps(valid, _mm256_cmp_ps(y, _mm256_set1_ps(kLargest), _CMP_LE_OQ));
    y = _mm256_min_ps(_mm256_max_ps(y, _mm256_set1_ps(kMin)), _mm256_set1_ps(kMax));
    const __m256i bits = _mm256_castps_si256(y);
    const __m256i octave =
        _mm256_sub_epi32(_mm256_srli_epi32(bits, 23), _mm256_set1_epi32(kFirstBiasedExponent));
    const __m256i mantissa = _mm256_or_si256(_mm256_and_si256(bits, _mm256_set1_epi32(kMantissa)),
                                             _mm256_set1_epi32(kOne));
    const __m256 t = _mm256_sub_ps(_mm256_castsi256_ps(mantissa), _mm256_set1_ps(1.5F));
    __m256 v = look_up(table.coefficient[kDegree].data(), octave);
    for (int k = kDegree - 1; k >= 0; --k)
      v = _mm256_add_ps(_mm256_mul_ps(v, t), look_up(table.coefficient[k].data(), octave));
    _mm256_storeu_ps(out + i, _mm256_max_ps(v, _mm256_setzero_ps()));
  }
  const bool rest = encode_portable(table, in + i, count - i, out + i);
  return rest && _mm256_movemask_ps(valid) == 0xff;
}

[[gnu::target("avx512f")]] bool encode_avx512(const Pu21Table& table, const float* in,
                                              std::size_t count, float* out) {
  __m512 low[kDegree + 1], high[kDegree + 1];  // columns 0..15 and 16..31
  for (int k = 0; k <= kDegree; ++k) {
    low[k] = _mm512_load_ps(table.coefficient[k].data());
    high[k] = _mm512_load_ps(table.coefficient[k].data() + 16);
  }
  __mmask16 valid = 0xffff;
  std::size_t i = 0;
  for (; i + 16 <= count; i += 16) {
    __m512 y = _mm512_loadu_ps(in + i);
    valid &= _mm512_cmp_ps_mask(y, _mm512_setzero_ps(), _CMP_GE_OQ) &
             _mm512_cmp_ps_mask(y, _mm512_set1_ps(kLargest), _CMP_LE_OQ);
    y = _mm512_min_ps(_mm512_max_ps(y, _mm512_set1_ps(kMin)), _mm512_set1_ps(kMax));
    const __m512i bits = _mm512_castps_si512(y);
    const __m512i octave =
        _mm512_sub_epi32(_mm512_srli_epi32(bits, 23), _mm512_set1_epi32(kFirstBiasedExponent));
    const __m512i mantissa = _mm512_or_epi32(_mm512_and_epi32(bits, _mm512_set1_epi32(kMantissa)),
                                             _mm512_set1_epi32(kOne));
    const __m512 t = _mm512_sub_ps(_mm512_castsi512_ps(mantissa), _mm512_set1_ps(1.5F));
    __m512 v = _mm512_permutex2var_ps(low[kDegree], octave, high[kDegree]);
    for (int k = kDegree - 1; k >= 0; --k)
      v = _mm512_add_ps(_mm512_mul_ps(v, t), _mm512_permutex2var_ps(low[k], octave, high[k]));
    _mm512_storeu_ps(out + i, _mm512_max_ps(v, _mm512_setzero_ps()));
  }
  const bool rest = encode_portable(table, in + i, count - i, out + i);
  return rest && valid == 0xffff;
}

#endif

}  // namespace

const Pu21Table& pu21_table(Pu21Variant variant) {
  static const std::array<Pu21Table, 4> tables = {
      make_table(Pu21Variant::kBanding), make_table(Pu21Variant::kBandingGlare),
      make_table(Pu21Variant::kPeaks), make_table(Pu21Variant::kPeaksGlare)};
  return tables[static_cast<std::size_t>(variant)];
}

bool pu21_encode_span(const Pu21Table& table, const float* luminance_cd_m2, std::size_t count,
                      float* pu21, Simd simd) {
  switch (simd) {
#if defined(__x86_64__)
    case Simd::kAvx512:
      return encode_avx512(table, luminance_cd_m2, count, pu21);
    case Simd::kAvx2:
      return encode_avx2(table, luminance_cd_m2, count, pu21);
#endif
    default:
      return encode_portable(table, luminance_cd_m2, count, pu21);
  }
}

}  // namespace wheatstone::detail
