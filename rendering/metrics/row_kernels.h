#pragma once
// The inner loops of PSNR and SSIM, on rows of floats. Internal to rendering/metrics.

#include <array>

#include "rendering/metrics/simd.h"

namespace wheatstone::detail {

/// Luminance (kLuminanceWeights, in float) of `count` pixels given as R, G, B, R, G, B, ... Returns
/// whether all samples were valid light (finite, >= 0).
bool luminance_row(const float* rgb, int count, float* luminance_cd_m2, Simd);

void sum_and_difference_row(const float* a, const float* b, int count, float* sum,
                            float* difference, Simd);

/// sums[i] += weights[i] values[i], with weight 1 where weights is null. Column sums in double keep
/// the order of additions, and so the result, free of the vectors' width.
void accumulate_row(const float* values, const float* weights, int count, double* sums, Simd);
/// sums[i] += (a[i] - b[i])^2.
void accumulate_squared_difference(const float* a, const float* b, int count, double* sums, Simd);

/// The 11-tap Gaussian of SSIM, sigma 1.5 px, normalised; symmetric, so tap[k] serves +k and -k.
struct SsimWindow {
  static constexpr int kRadius = 5, kTaps = 2 * kRadius + 1;
  std::array<float, kRadius + 1> tap{};
  SsimWindow();
};

/// Moments of two pictures x and y under a window, in the form s = x + y and d = x - y.
/// The variance of s is gathered in two steps, as the law of total variance allows (variance
/// within columns, then of the columns' means), each about a local value: taken as E[s^2] - E[s]^2
/// it would lose four digits to cancellation in float.
struct MomentRows {
  float *mean_s, *variance_s, *mean_d, *square_d;
};

/// Step 1, down the columns: the window over 11 rows of s and of d, at `count` columns.
void window_columns(const SsimWindow&, const float* const* rows_s, const float* const* rows_d,
                    int count, MomentRows out, Simd);

/// Step 2, along the row: the window over columns i..i+10 of step 1 gives pixel i, for `count`
/// pixels: the SSIM and its contrast-structure factor. With 2 sigma_xy = (var s - var d) / 2 and
/// sigma_x^2 + sigma_y^2 = (var s + var d) / 2, and the means alike, both factors of SSIM become
/// 1 - b / a, which is exactly 1 where x = y.
void window_row(const SsimWindow&, MomentRows columns, int count, float* ssim,
                float* contrast_structure, Simd);

}  // namespace wheatstone::detail
