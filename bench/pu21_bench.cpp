// Speed of the PU21 encoding, on one core, beside copies of the same floats: of an array that the
// caches hold, and of one far larger than they, where the memory's bandwidth decides.

#include <cstring>
#include <vector>

#include "bench/harness.h"
#include "rendering/metrics/pu21.h"
#include "rendering/metrics/pu21_table.h"

namespace wheatstone {
namespace {

constexpr std::size_t kCached = std::size_t{1} << 20;   // 4 MiB
constexpr std::size_t kImages = std::size_t{64} << 20;  // 256 MiB, seven 2160x1440 RGB pictures

std::vector<float> luminances(std::size_t count) {
  std::vector<float> out(count);
  for (std::size_t i = 0; i < count; ++i)
    out[i] = 0.005F + 1e-2F * static_cast<float>(i * 7919 % 1000000);
  return out;
}

template <class Body>
void run(benchmark::State& state, Body body) {
  const auto count = static_cast<std::size_t>(state.range(0));
  const std::vector<float> in = luminances(count);
  std::vector<float> out(count);
  for (auto _ : state) {
    body(in, out);
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

void BM_memcpy(benchmark::State& state) {
  run(state, [](const auto& in, auto& out) {
    std::memcpy(out.data(), in.data(), in.size() * sizeof(float));
  });
}
BENCHMARK(BM_memcpy)->Arg(kCached)->Arg(kImages);

// The copy of the STREAM benchmark: a loop that reads and writes floats, with ordinary stores (the
// option keeps the compiler from making it a memcpy).
[[gnu::optimize("no-tree-loop-distribute-patterns"), gnu::noinline]] void copy(
    const float* __restrict from, float* __restrict to, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) to[i] = from[i];
}

void BM_stream_copy(benchmark::State& state) {
  run(state, [](const auto& in, auto& out) { copy(in.data(), out.data(), in.size()); });
}
BENCHMARK(BM_stream_copy)->Arg(kCached)->Arg(kImages);

void BM_pu21_encode(benchmark::State& state) {
  run(state, [](const auto& in, auto& out) { pu21_encode(in, out); });
}
BENCHMARK(BM_pu21_encode)->Arg(kCached)->Arg(kImages);

template <Simd kSimd>
void BM_pu21_encode_level(benchmark::State& state) {
  if (best_simd() < kSimd) return state.SkipWithError("this processor has no such instructions");
  run(state, [](const auto& in, auto& out) {
    detail::pu21_encode_span(detail::pu21_table(Pu21Variant::kBandingGlare), in.data(), in.size(),
                             out.data(), kSimd);
  });
}
BENCHMARK_TEMPLATE(BM_pu21_encode_level, Simd::kAvx2)->Arg(kCached)->Arg(kImages);
BENCHMARK_TEMPLATE(BM_pu21_encode_level, Simd::kPortable)->Arg(kCached);

void BM_pu21_encode_formula(benchmark::State& state) {
  run(state, [](const auto& in, auto& out) {
    for (std::size_t i = 0; i < in.size(); ++i) out[i] = static_cast<float>(pu21_encode(in[i]));
  });
}
BENCHMARK(BM_pu21_encode_formula)->Arg(kCached);

WHEATSTONE_RATIO("images_encode_throughput_over_stream_copy", "BM_stream_copy/67108864",
                 "BM_pu21_encode/67108864");
WHEATSTONE_RATIO("images_encode_throughput_over_memcpy", "BM_memcpy/67108864",
                 "BM_pu21_encode/67108864");
WHEATSTONE_RATIO("cached_encode_throughput_over_stream_copy", "BM_stream_copy/1048576",
                 "BM_pu21_encode/1048576");
WHEATSTONE_RATIO("cached_encode_throughput_over_memcpy", "BM_memcpy/1048576",
                 "BM_pu21_encode/1048576");
WHEATSTONE_RATIO("times_faster_than_formula", "BM_pu21_encode_formula/1048576",
                 "BM_pu21_encode/1048576");

}  // namespace
}  // namespace wheatstone
