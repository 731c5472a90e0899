#pragma once
// How Wheatstone measures speed: Google Benchmark cases, every case repeated and the repetitions of
// all cases interleaved at random, so that a busy machine disturbs both sides of a ratio alike.
//
//   static void BM_ours(benchmark::State& state) { for (auto _ : state) ... }
//   BENCHMARK(BM_ours);  BENCHMARK(BM_plain);
//   WHEATSTONE_RATIO("times_faster_than_plain", "BM_plain", "BM_ours");
//
// The program (one per bench/<name>_bench.cpp) writes medians, spreads and ratios as JSON with
// `--json FILE`, and takes every option of Google Benchmark.

#include <benchmark/benchmark.h>

#include <string>

namespace wheatstone::bench {

/// Registers ratio = median(numerator) / median(denominator), by full case names. The returned
/// value only serves static initialisation.
bool add_ratio(const std::string& name, const std::string& numerator,
               const std::string& denominator);

/// A measured fact that is no time (a loss, a peak memory), stored with its unit in the name.
void add_figure(const std::string& name, double value);

}  // namespace wheatstone::bench

#define WHEATSTONE_RATIO(name, numerator, denominator)                                          \
  [[maybe_unused]] static const bool BENCHMARK_PRIVATE_CONCAT(wheatstone_ratio_, __LINE__, 0) = \
      ::wheatstone::bench::add_ratio(name, numerator, denominator)
