#include "calib/photon_transfer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "core/random.h"

namespace wheatstone {
namespace {

const SensorNoise kTruth{{0.422044, 0.384277, 0.388967}, 2.5, 3.02845};

/// A pair of uneven flat fields (one corner has half the light of the other) as such a sensor
/// sees them.
FlatPair flats(double electrons, double gain, std::uint64_t seed) {
  const auto frame = [&](std::uint64_t stream) {
    MosaicImage m{cv::Mat1w(96, 128)};
    RandomStream random(seed, stream);
    for (int r = 0; r < m.height(); ++r)
      for (int c = 0; c < m.width(); ++c) {
        const double k =
            kTruth.dn_per_electron[static_cast<std::size_t>(bayer_colour(m.pattern, r, c))];
        const double light = electrons * (0.5 + 0.5 * c / m.width());
        const double n = random.poisson(light) + kTruth.read_noise_e * random.normal();
        const double dn = 512 + k * (gain * n + kTruth.adc_noise * random.normal());
        m.dn(r, c) = static_cast<std::uint16_t>(std::lround(std::clamp(dn, 0.0, 16383.0)));
      }
    return m;
  };
  return {frame(0), frame(1), gain};
}

constexpr std::array<double, 4> kBlack = {512, 512, 512, 512};

TEST(PhotonTransfer, FindsTheNoiseWithItsError) {
  double z2 = 0;
  const int runs = 30;
  for (std::uint64_t run = 0; run < runs; ++run) {
    std::vector<FlatPair> pairs;
    for (const double gain : {1.0, 4.0, 16.0})
      for (const double electrons : {0.0, 30.0, 300.0, 1500.0})
        pairs.push_back(flats(electrons, gain, 100 * run + pairs.size()));
    const PhotonTransfer t = measure_sensor_noise(pairs, kBlack, 16383);
    EXPECT_TRUE(t.separated);
    EXPECT_NEAR(t.noise.dn_per_electron[1], 0.384277, 0.02 * 0.384277);
    EXPECT_NEAR(t.noise.read_noise_e, 2.5, 0.1);
    EXPECT_NEAR(t.noise.adc_noise, 3.02845, 0.15);
    EXPECT_NEAR(t.chi2_per_measurement, 1, 0.9);
    const auto add = [&](double value, double truth, double sigma) {
      z2 += std::pow((value - truth) / sigma, 2) / (5 * runs);
    };
    for (std::size_t c = 0; c < 3; ++c)
      add(t.noise.dn_per_electron[c], kTruth.dn_per_electron[c], t.sigma.dn_per_electron[c]);
    add(t.noise.read_noise_e, kTruth.read_noise_e, t.sigma.read_noise_e);
    add(t.noise.adc_noise, kTruth.adc_noise, t.sigma.adc_noise);
  }
  EXPECT_NEAR(std::sqrt(z2), 1, 0.25);
}

TEST(PhotonTransfer, OneGainGivesTheSumOfBothNoises) {
  std::vector<FlatPair> pairs;
  for (const double electrons : {0.0, 100.0, 1000.0, 8000.0, 20000.0})
    pairs.push_back(flats(electrons, 1, pairs.size()));
  const PhotonTransfer t = measure_sensor_noise(pairs, kBlack, 16383);
  EXPECT_FALSE(t.separated);
  EXPECT_EQ(t.noise.read_noise_e, 0);
  EXPECT_NEAR(t.noise.adc_noise, std::hypot(2.5, 3.02845), 0.1);
  EXPECT_NEAR(t.noise.dn_per_electron[0], 0.422044, 0.01);
}

TEST(PhotonTransfer, UselessPairsAreRefusedByIndex) {
  const std::vector<FlatPair> good = {flats(0, 1, 1), flats(500, 1, 2), flats(5000, 1, 3)};
  const auto refused = [&](std::vector<FlatPair> pairs, const std::string& part) {
    try {
      measure_sensor_noise(pairs, kBlack, 16383);
      FAIL() << part;
    } catch (const ArgumentError& e) {
      EXPECT_THAT(e.what(), testing::HasSubstr(part));
    }
  };
  refused({good[0], good[1]}, "three pairs");
  refused({good[0], good[1], flats(60000, 1, 4)}, "pair 2 has saturated");
  std::vector<FlatPair> bad = good;
  bad[1].b.dn = cv::Mat1w(bad[1].b.dn.colRange(0, 64));
  refused(bad, "pair 1");
  bad = good;
  bad[2].gain = 0;
  refused(bad, "pair 2");
}

}  // namespace
}  // namespace wheatstone
