// Speed of CaMoJAB: one evaluation with the spectrum at hand and a batch, beside the same formulas
// worked out bin by bin on whole spectra.

#include <algorithm>
#include <cmath>
#include <vector>

#include "bench/harness.h"
#include "rendering/motion_quality/camojab.h"
#include "rendering/motion_quality/camojab_parts.h"
#include "rendering/motion_quality/grey_texture.h"

namespace wheatstone {
namespace {

using camojab::kHalf;

constexpr CamojabConditions kConditions{60, 60, 15, 1, 150, 2, 1, 1};

const Camojab& model() {
  static const Camojab model{CamojabTexture(procedural_texture("noise640x544"))};
  return model;
}

/// Every bin by itself, as one would write the formulas down.
CamojabQuality plain(const CamojabSpectrum& amplitude, const CamojabConditions& c) {
  const CamojabModel m;
  const Eigen::ArrayXd mip =
      camojab::mip_gain(m, c.mip_level, std::min(c.shading_rate_x, c.shading_rate_y));
  const Eigen::ArrayXd motion = camojab::motion_gain(m, c);
  const auto offsets_x = camojab::replica_offsets(m, c.shading_rate_x),
             offsets_y = camojab::replica_offsets(m, c.shading_rate_y);
  const int columns = camojab::retained_bins(m, c.shading_rate_x),
            rows = camojab::retained_bins(m, c.shading_rate_y),
            shift = camojab::alias_shift_bins(m, c);
  const double beta = m.weights.beta;
  const StaticCsf static_csf(c.luminance_cd_m2);
  const auto sensitivity = [&](int kx, int ky, double omega_hz) {
    return camojab::sensitivity(camojab::radius_bins(m, kx, ky), omega_hz, c, static_csf);
  };
  double spatial = 0, temporal = 0;
  for (int ky = -kHalf; ky < kHalf; ++ky)
    for (int kx = -kHalf; kx < kHalf; ++kx) {
      const double s = sensitivity(kx, ky, 0);
      spatial += std::pow(amplitude(ky + kHalf, kx + kHalf) * s, beta);
      if (std::abs(kx) > columns || std::abs(ky) > rows) continue;
      double sum = 0;
      for (const int dy : offsets_y)
        for (const int dx : offsets_x) {
          const int y = ky + dy + kHalf, x = kx + dx + kHalf;
          if (y >= 0 && y < kCamojabSize && x >= 0 && x < kCamojabSize)
            sum += amplitude(y, x) * mip[y] * mip[x];
        }
      spatial -= std::pow(sum * motion[kx + kHalf] * s, beta);
      if (kx + shift < kHalf)
        temporal += std::pow(sum * sensitivity(kx + shift, ky, c.refresh_hz), beta);
    }
  constexpr double kBins = double(kCamojabSize) * kCamojabSize;
  return camojab::quality(m.weights, spatial / kBins, temporal / kBins);
}

void BM_plain(benchmark::State& state) {
  const CamojabTexture texture(procedural_texture("noise640x544"));
  for (auto _ : state) benchmark::DoNotOptimize(plain(texture.amplitude(), kConditions));
  const CamojabQuality a = plain(texture.amplitude(), kConditions),
                       b = model().evaluate(kConditions);
  if (std::abs(a.quality - b.quality) > 1e-9 * std::abs(a.quality))
    state.SkipWithError("the two sides disagree");
}
BENCHMARK(BM_plain)->Unit(benchmark::kMillisecond);

void BM_evaluate(benchmark::State& state) {
  model();
  for (auto _ : state) benchmark::DoNotOptimize(model().evaluate(kConditions));
}
BENCHMARK(BM_evaluate)->Unit(benchmark::kMillisecond);

void BM_evaluate_published(benchmark::State& state) {
  const Camojab published(CamojabTexture(procedural_texture("noise640x544")),
                          CamojabModel::preset(MotionQualityPreset::kPublished));
  for (auto _ : state) benchmark::DoNotOptimize(published.evaluate(kConditions));
}
BENCHMARK(BM_evaluate_published)->Unit(benchmark::kMillisecond);

/// 64 conditions as a planner asks them: all speeds and refresh rates at one mip level and rate.
void BM_batch_of_64(benchmark::State& state) {
  std::vector<CamojabConditions> batch(64, kConditions);
  for (std::size_t i = 0; i < batch.size(); ++i) {
    batch[i].refresh_hz = 30 + 15.0 * static_cast<double>(i % 8);
    batch[i].speed_deg_per_s = 5.0 * static_cast<double>(i / 8);
  }
  for (auto _ : state) benchmark::DoNotOptimize(model().evaluate(batch));
}
BENCHMARK(BM_batch_of_64)->Unit(benchmark::kMillisecond)->UseRealTime();

WHEATSTONE_RATIO("evaluate_times_faster_than_plain", "BM_plain", "BM_evaluate");
WHEATSTONE_RATIO("batch_of_64_over_one", "BM_batch_of_64/real_time", "BM_evaluate");

}  // namespace
}  // namespace wheatstone
