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
#include "rendering/metrics/hdrvdp3/plane.h"
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
  cv::Mat1d shared = make_plane(test.size(), [&](int r, int c) {
    return std::min(std::abs(test(r, c)), std::abs(reference(r, c)));
  });
  cv::boxFilter(shared, shared, -1, {3, 3}, {-1, -1}, true, cv::BORDER_CONSTANT);
  return shared;
}

/// Activity of the neighbour bands, in the size of band b. The low-pass residual masks no other.
cv::Mat1d neighbour_activity(const std::vector<cv::Mat1d>& activity, int b) {
  const int bands = static_cast<int>(activity.size());
  const cv::Size size = activity[b].size();
  cv::Mat1d sum = cv::Mat1d::zeros(size);
  for (const int neighbour : {b - 1, b + 1}) {
    if (neighbour < 0 || (neighbour > b && neighbour >= bands - 1)) continue;
    const cv::Mat1d resized = resize_bicubic(activity[neighbour], size);
    fill_plane(sum, [&](int r, int c) { return sum(r, c) + std::max(resized(r, c), 0.0); });
  }
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

/// Neural sensitivity to the low-pass residual. It reaches from the mean to beyond its nominal
/// frequency, so that one number is taken, for the frequency that dominates.
double residual_sensitivity(const cv::Mat1d& difference, const cv::Mat1d& log10_adaptation,
                            double band_cpd) {
  const double frequency_cpd = dominant_frequency_cpd(difference, 4 * band_cpd);
  return neural_csf(frequency_cpd, std::pow(10, cv::mean(log10_adaptation)[0]));
}

}  // namespace

BandDifferences visible_difference(std::vector<cv::Mat1d>&& test,
                                   const std::vector<cv::Mat1d>& reference,
                                   const cv::Mat1d& log10_adaptation, const cv::Mat1d& differs,
                                   double pixels_per_degree) {
  const int bands = static_cast<int>(test.size());
  std::vector<cv::Mat1d> activity;
  for (int b = 0; b < bands; ++b) activity.push_back(mutual_activity(test[b], reference[b]));

  BandDifferences out;
  for (int b = 0; b < bands; ++b) {
    const double band_cpd = band_frequency_cpd(b, pixels_per_degree);
    const cv::Size size = test[b].size();
    const cv::Mat1d adaptation = resize_bicubic(log10_adaptation, size);
    const cv::Mat1d mask = resize_bicubic(differs, size);
    const cv::Mat1d neighbours = neighbour_activity(activity, b);
    cv::Mat1d& difference = test[b];
    fill_plane(difference, [&](int r, int c) { return difference(r, c) - reference[b](r, c); });
    const LogTable csf = b < bands - 1
                             ? neural_csf_table(band_cpd)
                             : LogTable(std::vector<double>(
                                   2, residual_sensitivity(difference, adaptation, band_cpd)));

    std::vector<double> row_sums(size.height);
    tbb::parallel_for(0, size.height, [&](int r) {
      double sum = 0;
      for (int c = 0; c < size.width; ++c) {
        double& d = difference(r, c);
        const double masking = kSelfMasking * std::pow(activity[b](r, c), kMasking) +
                               kCrossMasking * std::pow(neighbours(r, c), kMasking);
        const double noise = std::pow(csf(adaptation(r, c)), -2 * kExcitation) + masking * masking;
        // D = |d|^p / sqrt(noise), as a logarithm, for the two powers that are taken of it.
        const double log_visible = kExcitation * std::log(std::abs(d)) - 0.5 * std::log(noise);
        sum += std::exp(kPooling * (log_visible + std::log(std::abs(mask(r, c)))));
        d = std::copysign(std::exp(kPsychometricSlope * log_visible), d);
      }
      row_sums[r] = sum;
    });
    const double mean =
        std::accumulate(row_sums.begin(), row_sums.end(), 0.0) / static_cast<double>(size.area());
    out.q_err += std::pow(mean, 1 / kPooling) / bands;
  }
  out.contrast = std::move(test);
  return out;
}

Detection detect(const BandDifferences& differences, double pixels_per_degree) {
  cv::Mat1d contrast = reconstruct_from_bands(differences.contrast);
  // Probability summation over a neighbourhood: the chances to miss it everywhere multiply.
  cv::Mat1d probability = make_plane(contrast.size(), [&](int r, int c) {
    return std::log(std::exp(-std::numbers::ln2 * std::abs(contrast(r, c))) + 1e-4);
  });
  gaussian_blur(probability, std::pow(10, -0.502280453708) * pixels_per_degree, BlurBorder::kZero);
  fill_plane(probability, [&](int r, int c) { return -std::expm1(probability(r, c)); });

  const auto largest_local_mean = [&](cv::Mat1d image) {
    gaussian_blur(image, 0.25 * pixels_per_degree, BlurBorder::kZero);
    double largest = 0;
    cv::minMaxLoc(image, nullptr, &largest);
    return largest;
  };
  const double p_det = largest_local_mean(probability.clone());
  fill_plane(contrast, [&](int r, int c) { return std::abs(contrast(r, c)); });
  return {probability, p_det, largest_local_mean(contrast)};
}

}  // namespace wheatstone
