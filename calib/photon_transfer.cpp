#include "calib/photon_transfer.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace wheatstone {
namespace {

constexpr double kQuantisation_dn2 = 1.0 / 12;
constexpr int kIterations = 20;

/// One colour of one pair.
struct Measurement {
  int colour;
  double gain, mean_dn, variance_dn2, count;
};

void add_measurements(const FlatPair& pair, const std::string& name,
                      const std::array<double, 4>& black_dn, int saturation_dn,
                      std::vector<Measurement>& out) {
  if (pair.a.dn.empty() || pair.a.dn.size() != pair.b.dn.size() || pair.a.pattern != pair.b.pattern)
    throw ArgumentError(name + " has frames of different size or pattern", "capture it again");
  if (!(pair.gain > 0) || !std::isfinite(pair.gain))
    throw ArgumentError(name + " has a gain of " + std::to_string(pair.gain), "give ISO / 100");
  std::array<double, 3> count{}, sum{}, difference{}, squares{};
  for (int r = 0; r < pair.a.height(); ++r)
    for (int c = 0; c < pair.a.width(); ++c) {
      const int a = pair.a.dn(r, c), b = pair.b.dn(r, c);
      if (std::max(a, b) >= saturation_dn)
        throw ArgumentError(name + " has saturated pixels", "expose it less");
      const auto k = static_cast<std::size_t>(bayer_colour(pair.a.pattern, r, c));
      count[k] += 1;
      sum[k] += 0.5 * (a + b) - black_dn[static_cast<std::size_t>(2 * (r & 1) + (c & 1))];
      difference[k] += a - b;
      squares[k] += static_cast<double>(a - b) * (a - b);
    }
  for (std::size_t k = 0; k < 3; ++k) {
    if (count[k] < 2) throw ArgumentError(name + " lacks a colour", "give larger frames");
    // The frames may differ a little in brightness; their mean difference is no noise.
    const double mean_difference = difference[k] / count[k];
    const double variance =
        (squares[k] - count[k] * mean_difference * mean_difference) / (count[k] - 1) / 2;
    out.push_back({static_cast<int>(k), pair.gain, sum[k] / count[k], variance - kQuantisation_dn2,
                   count[k]});
  }
}

}  // namespace

PhotonTransfer measure_sensor_noise(const std::vector<FlatPair>& pairs,
                                    const std::array<double, 4>& black_dn, int saturation_dn) {
  if (pairs.size() < 3)
    throw ArgumentError("three pairs are the fewest that tell photon from electronic noise",
                        "add pairs of other brightness");
  std::vector<Measurement> seen;
  PhotonTransfer out;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    add_measurements(pairs[i], "pair " + std::to_string(i), black_dn, saturation_dn, seen);
    out.separated = out.separated || pairs[i].gain != pairs[0].gain;
  }

  // Var = k m g + k^2 (read^2 g^2 + adc^2). Gauss-Newton for k_R, k_G, k_B, read^2, adc^2, from the
  // k of photon noise alone and both squares alike as the darkest pair has them: without any, its
  // tiny mean would have to explain its variance.
  Eigen::Matrix<double, 5, 1> p;
  p << 0, 0, 0, 0, 0;
  for (int k = 0; k < 3; ++k) {
    double m = 0, v = 0;
    for (const Measurement& s : seen)
      if (s.colour == k) m += s.mean_dn * s.gain, v += s.variance_dn2;
    p[k] = std::max(v / std::max(m, 1e-9), 1e-6);
  }
  const Measurement& darkest =
      *std::min_element(seen.begin(), seen.end(), [](const Measurement& a, const Measurement& b) {
        return a.mean_dn / a.gain < b.mean_dn / b.gain;
      });
  const double k2 = p[darkest.colour] * p[darkest.colour];
  p[3] = std::max(darkest.variance_dn2, 0.0) / k2 /
         (out.separated ? darkest.gain * darkest.gain + 1 : 1);
  if (out.separated) p[4] = p[3];
  const Eigen::Index unknowns = out.separated ? 5 : 4;
  Eigen::MatrixXd J(static_cast<Eigen::Index>(seen.size()), unknowns);
  Eigen::VectorXd residual(static_cast<Eigen::Index>(seen.size()));
  Eigen::MatrixXd covariance;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    for (Eigen::Index i = 0; i < residual.size(); ++i) {
      const Measurement& s = seen[static_cast<std::size_t>(i)];
      const double k = p[s.colour], g2 = s.gain * s.gain;
      const double electronic = out.separated ? p[3] * g2 + p[4] : p[3];
      const double model = k * s.mean_dn * s.gain + k * k * electronic;
      // A variance of n differences is known to sqrt(2 / n) of itself.
      const double sigma =
          (std::max(model, 0.0) + kQuantisation_dn2) * std::sqrt(2 / (s.count - 1));
      J.row(i).setZero();
      J(i, s.colour) = (s.mean_dn * s.gain + 2 * k * electronic) / sigma;
      J(i, 3) = k * k * (out.separated ? g2 : 1) / sigma;
      if (out.separated) J(i, 4) = k * k / sigma;
      residual[i] = (s.variance_dn2 - model) / sigma;
    }
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(J);
    if (qr.rank() < unknowns)
      throw ArgumentError("the pairs do not differ enough to tell the kinds of noise apart",
                          "add darker and brighter pairs");
    p.head(unknowns) += qr.solve(residual);
    covariance = (J.transpose() * J).inverse();
  }
  if (!p.allFinite() || p.head<3>().minCoeff() <= 0)
    throw ArgumentError("the pairs' noise does not rise with their light",
                        "check that each pair shows the same light");
  const auto deviation = [&](Eigen::Index i) { return std::sqrt(covariance(i, i)); };
  const auto root = [&](Eigen::Index i, double& value, double& sigma) {
    value = std::sqrt(std::max(p[i], 0.0));
    sigma = deviation(i) / (2 * std::max(value, std::sqrt(deviation(i)) / 2));
  };
  for (std::size_t k = 0; k < 3; ++k) {
    out.noise.dn_per_electron[k] = p[static_cast<Eigen::Index>(k)];
    out.sigma.dn_per_electron[k] = deviation(static_cast<Eigen::Index>(k));
  }
  if (out.separated) root(3, out.noise.read_noise_e, out.sigma.read_noise_e);
  root(out.separated ? 4 : 3, out.noise.adc_noise, out.sigma.adc_noise);
  out.chi2_per_measurement =
      residual.squaredNorm() / std::max(1.0, static_cast<double>(residual.size() - unknowns));
  return out;
}

}  // namespace wheatstone
