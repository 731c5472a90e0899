// Speed and loss of the shading-rate allocation for a frame of 1920x1080 (8,160 tiles, 7 rates) on
// one core, beside the plain way: polynomials as printed, and the released greedy; for the optimum
// a dynamic program over the whole budget.

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <vector>

#include "bench/harness.h"
#include "core/random.h"
#include "rendering/motion_quality/alsarr/rate_allocation.h"
#include "rendering/motion_quality/alsarr/tile_quality.h"

namespace wheatstone {
namespace {

constexpr int kTilesX = 120, kTilesY = 68;
constexpr double kRefresh_hz = 60;

std::filesystem::path reference_folder() {
  const char* set = std::getenv("WHEATSTONE_SHARED");
  return std::filesystem::path(set ? set : WHEATSTONE_DEFAULT_SHARED) / "reference/perception";
}

/// The sample frame: a game's buffers with the reference's synthetic luminance.
struct SampleFrame {
  PolynomialTable table;
  TileBuffers buffers;

  SampleFrame()
      : table(PolynomialTable::read(reference_folder() / "vectors/sample_polynomials.csv")),
        buffers(read_tile_buffers({reference_folder() / "sample_frame/motion_n.exr",
                                   reference_folder() / "sample_frame/materials_n.exr",
                                   {},
                                   100},
                                  {1920, 1080, kRefresh_hz, 60})) {
    for (int y = 0; y < buffers.tiles_y(); ++y)
      for (int x = 0; x < buffers.tiles_x(); ++x)
        buffers.luminance_cd_m2(y, x) =
            std::pow(10, -1 + 3.4 * ((7 * x + 13 * y) % 101) / 100.0) + 0.01;
  }
};

/// The same with its last row of tiles twice: the half row that the sample leaves out.
const SampleFrame& full_frame() {
  static const SampleFrame kFrame = [] {
    SampleFrame frame;
    const auto extend = [](auto& buffer) { buffer.push_back(buffer.row(buffer.rows - 1).clone()); };
    extend(frame.buffers.speed_x_deg_per_s);
    extend(frame.buffers.speed_y_deg_per_s);
    extend(frame.buffers.material);
    extend(frame.buffers.mip_level);
    extend(frame.buffers.luminance_cd_m2);
    return frame;
  }();
  return kFrame;
}

AllocationProblem full_problem(double fraction) {
  AllocationProblem p;
  p.quality = TileQualityModel(full_frame().table, kRefresh_hz).evaluate(full_frame().buffers);
  p.budget = budget_px(fraction, p.tiles());
  return p;
}

double fraction_of(const benchmark::State& state) {
  return 0.0001 * static_cast<double>(state.range(0));
}

void BM_evaluate(benchmark::State& state) {
  const TileQualityModel model(full_frame().table, kRefresh_hz);
  for (auto _ : state) benchmark::DoNotOptimize(model.evaluate(full_frame().buffers));
}
BENCHMARK(BM_evaluate);

/// Equation 6.10 as printed, for every tile and rate.
std::vector<double> evaluate_plainly() {
  const auto& [table, b] = full_frame();
  std::vector<double> quality;
  for (int x = 0; x < b.tiles_x(); ++x)
    for (int y = 0; y < b.tiles_y(); ++y)
      for (const ShadingRate& rate : kShadingRates) {
        const PolynomialTable::MipRow& row = table.at(b.material(y, x), b.mip_level(y, x));
        const auto axis = [&](int block_px, double speed) {
          if (block_px == 4) return 0.0;
          return row[block_px == 2 ? 0 : 1](speed, kRefresh_hz, b.luminance_cd_m2(y, x));
        };
        quality.push_back((axis(rate.width_px, b.speed_x_deg_per_s(y, x)) +
                           axis(rate.height_px, b.speed_y_deg_per_s(y, x))) /
                              2 +
                          kTileQualityOffset);
      }
  return quality;
}

void BM_evaluate_plain(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(evaluate_plainly());
}
BENCHMARK(BM_evaluate_plain);

void BM_frame_plain(benchmark::State& state) {
  AllocationProblem p = full_problem(fraction_of(state));
  for (auto _ : state) {
    p.quality = evaluate_plainly();
    benchmark::DoNotOptimize(allocate(p, AllocationSolver::kGreedy));
  }
}
BENCHMARK(BM_frame_plain)->Arg(2500);

/// What a renderer does each frame.
void BM_frame_fast(benchmark::State& state) {
  const TileQualityModel model(full_frame().table, kRefresh_hz);
  AllocationProblem p = full_problem(fraction_of(state));
  for (auto _ : state) {
    p.quality = model.evaluate(full_frame().buffers);
    benchmark::DoNotOptimize(allocate(p, AllocationSolver::kFast));
  }
}
BENCHMARK(BM_frame_fast)->Arg(625)->Arg(1250)->Arg(2500)->Arg(5000);

void BM_allocate(benchmark::State& state, AllocationSolver solver) {
  const AllocationProblem p = full_problem(fraction_of(state));
  for (auto _ : state) benchmark::DoNotOptimize(allocate(p, solver));
}
BENCHMARK_CAPTURE(BM_allocate, greedy, AllocationSolver::kGreedy)->Arg(2500);
BENCHMARK_CAPTURE(BM_allocate, fast, AllocationSolver::kFast)->Arg(2500);
BENCHMARK_CAPTURE(BM_allocate, exact, AllocationSolver::kExact)->Arg(2500);

/// Random qualities of few different values: many ties, the hardest kind for the exact solver.
AllocationProblem tied_problem() {
  RandomStream random(1, 0);
  AllocationProblem p;
  for (int i = 0; i < kTilesX * kTilesY; ++i) {
    const auto draw = [&] { return std::floor(4 * random.uniform()) / 4; };
    const double hx = 3 * draw(), fx = hx + 4 * draw(), hy = 3 * draw(), fy = hy + 4 * draw();
    for (const double q :
         {0.0, hx / 2, hy / 2, (hx + hy) / 2, (fx + hy) / 2, (hx + fy) / 2, (fx + fy) / 2})
      p.quality.push_back(q + 0.1);
  }
  p.budget = budget_px(0.25, p.tiles());
  return p;
}

void BM_allocate_ties(benchmark::State& state, AllocationSolver solver) {
  const AllocationProblem p = tied_problem();
  for (auto _ : state) benchmark::DoNotOptimize(allocate(p, solver));
}
BENCHMARK_CAPTURE(BM_allocate_ties, fast, AllocationSolver::kFast);
BENCHMARK_CAPTURE(BM_allocate_ties, exact, AllocationSolver::kExact);

/// The textbook way: quality by tile and cost used, with a choice kept for every state.
void BM_exact_plain(benchmark::State& state) {
  const AllocationProblem p = full_problem(fraction_of(state));
  const auto capacity = static_cast<std::size_t>(p.budget / 16);
  for (auto _ : state) {
    std::vector<double> best(capacity + 1, -std::numeric_limits<double>::infinity()), next;
    std::vector<std::vector<std::uint8_t>> choices;
    best[0] = 0;
    for (std::size_t tile = 0; tile < p.tiles(); ++tile) {
      next.assign(capacity + 1, -std::numeric_limits<double>::infinity());
      choices.emplace_back(capacity + 1);
      for (int k = 0; k < kShadingRateCount; ++k) {
        const auto cost = static_cast<std::size_t>(p.cost[k] / 16);
        const double quality = p.quality[tile * kShadingRateCount + k];
        for (std::size_t used = cost; used <= capacity; ++used)
          if (best[used - cost] + quality > next[used]) {
            next[used] = best[used - cost] + quality;
            choices.back()[used] = static_cast<std::uint8_t>(k);
          }
      }
      best.swap(next);
    }
    benchmark::DoNotOptimize(choices);
  }
}
BENCHMARK(BM_exact_plain)->Arg(2500)->Iterations(1)->Unit(benchmark::kMillisecond);

WHEATSTONE_RATIO("plain_over_evaluate", "BM_evaluate_plain", "BM_evaluate");
WHEATSTONE_RATIO("plain_over_fast_frame", "BM_frame_plain/2500", "BM_frame_fast/2500");
WHEATSTONE_RATIO("greedy_over_fast", "BM_allocate/greedy/2500", "BM_allocate/fast/2500");
WHEATSTONE_RATIO("plain_over_exact", "BM_exact_plain/2500/iterations:1", "BM_allocate/exact/2500");

/// In a process of its own, so that nothing else counts.
double peak_memory_of_exact_mb() {
  const pid_t child = fork();
  if (child == 0) {
    const Allocation a = allocate(full_problem(0.25), AllocationSolver::kExact);
    _exit(a.choice.empty());
  }
  rusage usage{};
  int status = 0;
  if (child < 0 || wait4(child, &status, 0, &usage) != child || status != 0)
    return std::numeric_limits<double>::infinity();
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

[[maybe_unused]] const bool kFigures = [] {
  bench::add_figure("exact_peak_memory_mb", peak_memory_of_exact_mb());
  const SampleFrame frame;
  AllocationProblem p;
  p.quality = TileQualityModel(frame.table, kRefresh_hz).evaluate(frame.buffers);
  for (const double fraction : {0.0625, 0.125, 0.25, 0.5}) {
    p.budget = budget_px(fraction, p.tiles());
    const double optimum = allocate(p, AllocationSolver::kExact).total_quality;
    const auto loss_percent = [&](AllocationSolver solver) {
      return 100 * (1 - allocate(p, solver).total_quality / optimum);
    };
    const std::string at = "_loss_percent_at_" + std::to_string(fraction).substr(0, 6);
    bench::add_figure("fast" + at, loss_percent(AllocationSolver::kFast));
    bench::add_figure("greedy" + at, loss_percent(AllocationSolver::kGreedy));
  }
  return true;
}();

}  // namespace
}  // namespace wheatstone
