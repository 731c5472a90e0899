// Speed of the PU21 encoding beside a plain copy of the same memory (both on one core).

#include <cstring>
#include <vector>

#include "bench/harness.h"
#include "rendering/metrics/pu21.h"

namespace wheatstone {
namespace {

constexpr std::size_t kCount = 1 << 20;

std::vector<float> luminances() {
  std::vector<float> out(kCount);
  for (std::size_t i = 0; i < kCount; ++i) out[i] = 0.005f + 1e-2f * static_cast<float>(i % 100000);
  return out;
}

void BM_copy(benchmark::State& state) {
  const std::vector<float> in = luminances();
  std::vector<float> out(kCount);
  for (auto _ : state) {
    std::memcpy(out.data(), in.data(), kCount * sizeof(float));
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(BM_copy);

void BM_pu21_encode_scalar(benchmark::State& state) {
  const std::vector<float> in = luminances();
  std::vector<float> out(kCount);
  for (auto _ : state) {
    for (std::size_t i = 0; i < kCount; ++i) out[i] = static_cast<float>(pu21_encode(in[i]));
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(BM_pu21_encode_scalar);

WHEATSTONE_RATIO("scalar_encode_over_copy", "BM_pu21_encode_scalar", "BM_copy");

}  // namespace
}  // namespace wheatstone
