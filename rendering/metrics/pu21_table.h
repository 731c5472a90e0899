#pragma once
// The PU21 curve as one polynomial for each octave of luminance: what the vectorised encoding
// evaluates. Internal to rendering/metrics; use pu21.h.

#include <array>

#include "rendering/metrics/pu21.h"
#include "rendering/metrics/simd.h"

namespace wheatstone::detail {

/// The curve before its lower clamp to 0 and without clamping the luminance.
double pu21_curve(double luminance_cd_m2, Pu21Variant);

/// Octave i covers 2^(i-8) <= luminance < 2^(i-7); with luminance = 2^(i-8) (1.5 + t), the value is
/// sum over k of coefficient[k][i] t^k, t in [-0.5, 0.5). Interpolates pu21_curve at the
/// Chebyshev points of each octave; the degree is the lowest that keeps the promise of pu21_encode
/// for images. 32 columns, so that one column index fits the vector
/// permutations; those beyond the 22 octaves of 0.005..10000 cd/m^2 are 0.
struct Pu21Table {
  static constexpr int kDegree = 7, kOctaves = 22, kColumns = 32, kLowestExponent = -8;
  alignas(64) std::array<std::array<float, kColumns>, kDegree + 1> coefficient{};
};

/// Built once for each variant.
const Pu21Table& pu21_table(Pu21Variant);

/// PU21 values of `count` luminances in cd/m^2, clamped to 0.005..10000. Returns whether all were
/// valid (finite, >= 0); otherwise the output at the invalid ones is meaningless.
bool pu21_encode_span(const Pu21Table&, const float* luminance_cd_m2, std::size_t count,
                      float* pu21, Simd);

}  // namespace wheatstone::detail
