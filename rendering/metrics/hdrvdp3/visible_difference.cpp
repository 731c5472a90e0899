#include "rendering/metrics/hdrvdp3/visible_difference.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "rendering/metrics/hdrvdp3/gaussian_blur.h"
#include "rendering/metrics/hdrvdp3/neural_csf.h"
#include "rendering/metrics/hdrvdp3/resize.h"
#include "rendering/metrics/hdrvdp3/steerable_pyramid.h"

namespace wheatstone {
namespace {

// Fitted for task "quality" of HDR-VDP 3.0.7.
const double kExcitation = std::pow(10, 0.3424);            // exponent p of a difference
const double kMasking = std::pow(10, 0.108934275615);       // exponent q of a masker
const double kSelfMasking = std::pow(10, 1.41846291721);    // weight of the band itself
const double kCrossMasking = std::pow(10, 0.136877512403);  // weight of its neighbours
const double kPsychometricSlope = std::pow(10, 0.34) / kExcitation;
constexpr double kPooling = 0.8;

/// What test and reference share in a band, locally.
cv::Mat1d mutual_activity(const cv::Mat1d& test, const cv::Mat1d& reference) {
  cv::Mat1d shared = cv::abs(test);
  cv::min(shared, cv::abs(reference), shared);
  cv::boxFilter(shared, shared, -1, {3, 3}, {-1, -1}, true, cv::BORDER_CONSTANT);
  return shared;
}

/// Activity of the neighbour bands, in the size of band b. The low-pass residual masks no one.
cv::Mat1d neighbour_activity(const std::vector<cv::Mat1d>& activity, int b) {
  const int bands = static_cast<int>(activity.size());
  cv::Mat1d sum = cv::Mat1d::zeros(activity[b].size());
  if (b > 0) sum += cv::max(resize_bicubic(activity[b - 1], sum.size()), 0);
  if (b < bands - 2) sum += cv::max(resize_bicubic(activity[b + 1], sum.size()), 0);
  return sum;
}

/// Frequency, cpd, of the strongest component of the low-pass residual's difference, mean apart;
/// 0 when there is none.
double dominant_frequency_cpd(const cv::Mat1d& difference, double samples_per_degree) {
  cv::Mat spectrum;
  cv::dft(difference, spectrum, cv::DFT_COMPLEX_OUTPUT);
  double strongest = 0, frequency_cpd = 0;
  for (int c = 0; c < spectrum.cols; ++c)
    for (int r = 0; r < spectrum.rows; ++r) {
      const double amplitude = std::abs(spectrum.at<std::complex<double>>(r, c));
      if ((r == 0 && c == 0) || !(amplitude > strongest)) continue;
      strongest = amplitude;
      const double y = std::min(r, spectrum.rows - r) / static_cast<double>(spectrum.rows);
      const double x = std::min(c, spectrum.cols - c) / static_cast<double>(spectrum.cols);
      frequency_cpd = std::hypot(x, y) * samples_per_degree;
    }
  return frequency_cpd;
}

/// Neural sensitivity to band b at every of its pixels.
cv::Mat1d sensitivity(const cv::Mat1d& difference, const cv::Mat1d& log10_adaptation, int b,
                      bool is_last, double pixels_per_degree) {
  const double band_cpd = band_frequency_cpd(b, pixels_per_degree);
  cv::Mat1d out = resize_bicubic(log10_adaptation, difference.size());
  if (is_last) {
    // The residual reaches from the mean to beyond its nominal frequency: one number, for the
    // frequency that dominates, instead of one per pixel.
    const double mean = cv::mean(cv::max(cv::min(out, 5), -5))[0];
    out.setTo(neural_csf(dominant_frequency_cpd(difference, 4 * band_cpd), std::pow(10, mean)));
    return out;
  }
  const LogTable csf = neural_csf_table(band_cpd);
  tbb::parallel_for(0, out.rows, [&](int r) {
    for (int c = 0; c < out.cols; ++c) out(r, c) = csf(out(r, c));
  });
  return out;
}

}  // namespace

BandDifferences visible_difference(const std::vector<cv::Mat1d>& test,
                                   const std::vector<cv::Mat1d>& reference,
                                   const cv::Mat1d& log10_adaptation, const cv::Mat1d& differs,
                                   double pixels_per_degree) {
  const int bands = static_cast<int>(test.size());
  std::vector<cv::Mat1d> activity;
  for (int b = 0; b < bands; ++b) activity.push_back(mutual_activity(test[b], reference[b]));

  BandDifferences out;
  for (int b = 0; b < bands; ++b) {
    cv::Mat1d difference = test[b] - reference[b];
    const cv::Mat1d csf =
        sensitivity(difference, log10_adaptation, b, b == bands - 1, pixels_per_degree);
    const cv::Mat1d neighbours = neighbour_activity(activity, b);
    const cv::Mat1d mask = resize_bicubic(differs, difference.size());
    std::vector<double> row_sums(difference.rows);
    tbb::parallel_for(0, difference.rows, [&](int r) {
      for (int c = 0; c < difference.cols; ++c) {
        double& d = difference(r, c);
        const double masking = kSelfMasking * std::pow(activity[b](r, c), kMasking) +
                               kCrossMasking * std::pow(neighbours(r, c), kMasking);
        const double noise = std::pow(csf(r, c), -2 * kExcitation) + masking * masking;
        // D = |d|^p / sqrt(noise), as a logarithm, for the two powers that are taken of it.
        const double log_visible = kExcitation * std::log(std::abs(d)) - 0.5 * std::log(noise);
        row_sums[r] += std::exp(kPooling * (log_visible + std::log(std::abs(mask(r, c)))));
        d = std::copysign(std::exp(kPsychometricSlope * log_visible), d);
      }
    });
    const double mean = std::accumulate(row_sums.begin(), row_sums.end(), 0.0) /
                        static_cast<double>(difference.total());
    out.q_err += std::pow(mean, 1 / kPooling) / bands;
    out.contrast.push_back(difference);
  }
  return out;
}

Detection detect(const BandDifferences& differences, double pixels_per_degree) {
  const cv::Mat1d contrast = cv::abs(reconstruct_from_bands(differences.contrast));
  // Probability summation over a neighbourhood: the chances to miss it everywhere multiply.
  cv::Mat1d probability(contrast.size());
  tbb::parallel_for(0, contrast.rows, [&](int r) {
    for (int c = 0; c < contrast.cols; ++c)
      probability(r, c) = std::log(std::exp(-std::numbers::ln2 * contrast(r, c)) + 1e-4);
  });
  probability = gaussian_blur(probability, std::pow(10, -0.502280453708) * pixels_per_degree,
                              BlurBorder::kZero);
  tbb::parallel_for(0, contrast.rows, [&](int r) {
    for (int c = 0; c < contrast.cols; ++c) probability(r, c) = -std::expm1(probability(r, c));
  });

  const auto largest_local_mean = [&](const cv::Mat1d& image) {
    double largest = 0;
    cv::minMaxLoc(gaussian_blur(image, 0.25 * pixels_per_degree, BlurBorder::kZero), nullptr,
                  &largest);
    return largest;
  };
  return {probability, largest_local_mean(probability), largest_local_mean(contrast)};
}

}  // namespace wheatstone
