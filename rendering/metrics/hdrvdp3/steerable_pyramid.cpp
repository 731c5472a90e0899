#include "rendering/metrics/hdrvdp3/steerable_pyramid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "rendering/metrics/hdrvdp3/plane.h"

namespace wheatstone {
namespace {

/// A filter of 2N - 1 taps that mirrors in both axes, from its centre to the right and down.
template <std::size_t N>
using QuadrantTaps = std::array<std::array<double, N>, N>;

// matlabPyrTools, sp0Filters (E. Simoncelli; MIT licence, copyright 2015
// LabForComputationalVision).
constexpr QuadrantTaps<5> kHighPass0 = {
    {{0.8554893, -0.09623594, -0.02420138, -0.00037321, -0.00024066},
     {-0.09623594, -0.06300923, -0.01437358, 0.00014597, -0.00033256},
     {-0.02420138, -0.01437358, -0.00161665, 0.00049271, -0.00033249},
     {-0.00037321, 0.00014597, 0.00049271, 0.00012631, -6.068e-05},
     {-0.00024066, -0.00033256, -0.00033249, -6.068e-05, 0.00059972}}};

constexpr QuadrantTaps<4> kLowPass0 = {{{0.3153017, 0.1524935, -0.0075632, -0.00374386},
                                        {0.1524935, 0.06441488, -0.0134416, -0.00037258},
                                        {-0.0075632, -0.0134416, -0.00611952, -0.00011371},
                                        {-0.00374386, -0.00037258, -0.00011371, -0.0004514}}};

constexpr QuadrantTaps<7> kLowPass = {
    {{0.1576508, 0.1348999, 0.07624674, 0.024496, -0.0037816, -0.0069489, -0.00187192},
     {0.1348999, 0.1116388, 0.06306262, 0.01722078, -0.00523618, -0.00700674, -0.00103164},
     {0.07624674, 0.06306262, 0.03220744, 0.00393862, -0.0067208, -0.00459642, -0.00018628},
     {0.024496, 0.01722078, 0.00393862, -0.00526002, -0.006401, -0.00244906, 0.00087414},
     {-0.0037816, -0.00523618, -0.0067208, -0.006401, -0.00305976, -0.00019038, -5.686e-05},
     {-0.0069489, -0.00700674, -0.00459642, -0.00244906, -0.00019038, 0.00141762, -0.00080644},
     {-0.00187192, -0.00103164, -0.00018628, 0.00087414, -5.686e-05, -0.00080644, -0.0002257}}};

constexpr QuadrantTaps<5> kBandPass = {
    {{0.9464195, -0.03158605, -0.03487008, -0.00909195, -0.01009473},
     {-0.03158605, -0.01730466, -0.02435662, -0.00762341, -0.00788939},
     {-0.03487008, -0.02435662, -0.0212954, -0.00727254, -0.0049425},
     {-0.00909195, -0.00762341, -0.00727254, -0.00462515, -0.00173864},
     {-0.01009473, -0.00788939, -0.0049425, -0.00173864, -9.066e-05}}};

int reflect(int i, int n) {
  if (i < 0) i = -i;
  return i < n ? i : 2 * (n - 1) - i;
}

/// Every `Step`-th sample, in both directions, of `in` filtered. The mirrored taps are added up
/// before they are weighted, which takes a quarter of the multiplications.
template <int Step = 1, std::size_t N>
cv::Mat1d filter(const cv::Mat1d& in, const QuadrantTaps<N>& taps) {
  constexpr int R = N - 1;
  cv::Mat1d out((in.rows + Step - 1) / Step, (in.cols + Step - 1) / Step);
  tbb::parallel_for(0, out.rows, [&](int r) {
    const int centre = r * Step;
    double* to = out[r];
    std::vector<double> folded(in.cols + 2 * R);  // rows centre - j and centre + j, added
    double* const sum = folded.data() + R;
    for (int j = 0; j <= R; ++j) {
      const double *above = in[reflect(centre - j, in.rows)],
                   *below = in[reflect(centre + j, in.rows)];
      const double share = j == 0 ? 0.5 : 1;
      for (int c = 0; c < in.cols; ++c) sum[c] = share * (above[c] + below[c]);
      for (int k = 1; k <= R; ++k) {
        sum[-k] = sum[k];
        sum[in.cols - 1 + k] = sum[in.cols - 1 - k];
      }
      for (int c = 0; c < out.cols; ++c) {
        const double* at = sum + c * Step;
        double value = taps[j][0] * at[0];
        for (int k = 1; k <= R; ++k) value += taps[j][k] * (at[-k] + at[k]);
        to[c] = j == 0 ? value : to[c] + value;
      }
    }
  });
  return out;
}

/// Samples at even positions, zeros between them.
cv::Mat1d spread(const cv::Mat1d& in, cv::Size size) {
  return make_plane(size, [&](int r, int c) { return (r | c) % 2 == 0 ? in(r / 2, c / 2) : 0.0; });
}

double band_scale(int band) {
  return std::ldexp(1.0, band);
}

}  // namespace

int steerable_levels(cv::Size size, double pixels_per_degree) {
  constexpr int kLowPassSide = 2 * kLowPass.size() - 1;
  int fitting = 0;
  for (int side = std::min(size.width, size.height); side >= kLowPassSide; side /= 2) ++fitting;
  return std::min(static_cast<int>(std::ceil(std::log2(pixels_per_degree))) - 2, fitting);
}

double band_frequency_cpd(int band, double pixels_per_degree) {
  return pixels_per_degree / 2 / band_scale(band);
}

std::vector<cv::Mat1d> steerable_bands(const cv::Mat1d& image, int levels) {
  std::vector<cv::Mat1d> bands = {filter(image, kHighPass0)};
  cv::Mat1d low = filter(image, kLowPass0);
  for (int level = 0; level < levels; ++level) {
    bands.push_back(filter(low, kBandPass));
    low = filter<2>(low, kLowPass);
  }
  bands.push_back(low);
  for (int b = 1; b < static_cast<int>(bands.size()); ++b) bands[b] /= band_scale(b);
  return bands;
}

cv::Mat1d reconstruct_from_bands(const std::vector<cv::Mat1d>& bands) {
  const int last = static_cast<int>(bands.size()) - 1;
  cv::Mat1d low = bands[last] * band_scale(last);
  for (int b = last - 1; b > 0; --b) {
    low = filter(spread(low, bands[b].size()), kLowPass);
    cv::scaleAdd(filter(bands[b], kBandPass), band_scale(b), low, low);
  }
  return filter(low, kLowPass0) + filter(bands[0], kHighPass0);
}

}  // namespace wheatstone
