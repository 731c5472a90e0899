#include "rendering/motion_quality/alsarr/rate_allocation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "tests/error_text.h"
#include "tests/rendering/motion_quality/alsarr/allocation_problems.h"

namespace wheatstone::testing {
namespace {

using ::testing::HasSubstr;

constexpr AllocationSolver kSolvers[] = {AllocationSolver::kGreedy, AllocationSolver::kExact,
                                         AllocationSolver::kFast};

/// Sums differ in their last digits with the order of their terms.
double rounding(const AllocationProblem& p) {
  double sum = 0;
  for (const double q : p.quality) sum += std::abs(q);
  return 1e-14 * sum;
}

/// What an answer says about itself must be true of its choices.
void expect_consistent(const AllocationProblem& p, const Allocation& a) {
  ASSERT_EQ(a.choice.size(), p.tiles());
  double quality = 0;
  std::int64_t cost = 0;
  for (std::size_t tile = 0; tile < p.tiles(); ++tile) {
    ASSERT_GE(a.choice[tile], 1);
    ASSERT_LE(a.choice[tile], kShadingRateCount);
    quality += p.quality[tile * kShadingRateCount + a.choice[tile] - 1];
    cost += p.cost[a.choice[tile] - 1];
  }
  EXPECT_NEAR(a.total_quality, quality, rounding(p));
  EXPECT_EQ(a.total_cost, cost);
  EXPECT_LE(a.total_cost, p.budget);
  EXPECT_GE(a.gap_bound, 0);
}

TEST(RateAllocation, ReferenceInstances) {
  std::ifstream in(std::string(WHEATSTONE_SOURCE_DIR) +
                   "/tests/vectors/motion_quality/knapsack_instances.json");
  const auto instances = nlohmann::json::parse(in)["instances"];
  ASSERT_EQ(instances.size(), 9u);
  for (const auto& instance : instances) {
    SCOPED_TRACE(instance["name"].get<std::string>());
    AllocationProblem p;
    p.cost = instance["bandwidth"].get<std::array<int, kShadingRateCount>>();
    p.budget = instance["budget"];
    for (const auto& row : instance["quality"])
      for (const double q : row) p.quality.push_back(q);
    const double optimum = instance["exact_optimum"];

    const Allocation greedy = allocate(p, AllocationSolver::kGreedy);
    expect_consistent(p, greedy);
    EXPECT_EQ(greedy.choice, instance["greedy_selection"].get<std::vector<std::uint8_t>>());
    EXPECT_EQ(greedy.total_cost, instance["greedy_bandwidth"].get<std::int64_t>());
    EXPECT_GE(greedy.total_quality + greedy.gap_bound, optimum - 1e-9);

    const Allocation exact = allocate(p, AllocationSolver::kExact);
    expect_consistent(p, exact);
    EXPECT_NEAR(exact.total_quality, optimum, 1e-9);
    EXPECT_EQ(exact.gap_bound, 0);

    const Allocation fast = allocate(p, AllocationSolver::kFast);
    expect_consistent(p, fast);
    EXPECT_GE(fast.total_quality, greedy.total_quality - rounding(p));
    EXPECT_LE(fast.total_quality, optimum + 1e-9);
    EXPECT_GE(fast.total_quality + fast.gap_bound, optimum - 1e-9);
  }
}

TEST(RateAllocation, ManyRandomProblemsAgainstPlainDynamicProgramming) {
  int greedy_suboptimal = 0, cases = 0;
  for (std::uint64_t seed = 0; seed < 150; ++seed)
    for (int kind = 0; kind < 4; ++kind) {
      RandomStream random(seed, 100);
      const int tiles = 1 + static_cast<int>(random.next() % 40);
      AllocationProblem p = random_problem(kind, tiles, seed);
      // From the minimum over barely more to more than everything.
      const std::int64_t most = 16 * tiles;
      for (const std::int64_t budget :
           {std::int64_t{tiles}, std::int64_t{tiles} + 1, std::int64_t{tiles} + tiles / 2 + 1,
            tiles + static_cast<std::int64_t>(random.next() % (15 * tiles + 1)), most - 1, most,
            most + 7}) {
        p.budget = std::max<std::int64_t>(budget, tiles);
        SCOPED_TRACE(::testing::Message() << "kind " << kind << ", seed " << seed << ", " << tiles
                                          << " tiles, budget " << p.budget);
        const double optimum = optimum_by_dynamic_programming(p);
        const Allocation greedy = allocate(p, AllocationSolver::kGreedy),
                         exact = allocate(p, AllocationSolver::kExact),
                         fast = allocate(p, AllocationSolver::kFast);
        for (const Allocation* a : {&greedy, &exact, &fast}) {
          expect_consistent(p, *a);
          EXPECT_LE(a->total_quality, optimum + rounding(p));
          EXPECT_GE(a->total_quality + a->gap_bound, optimum - rounding(p));
        }
        EXPECT_NEAR(exact.total_quality, optimum, rounding(p));
        EXPECT_EQ(exact.gap_bound, 0);
        EXPECT_GE(fast.total_quality, greedy.total_quality - rounding(p));
        greedy_suboptimal += greedy.total_quality < optimum - 1e-6;
        ++cases;
      }
    }
  EXPECT_GT(greedy_suboptimal, cases / 4);  // or the comparison would prove little
}

TEST(RateAllocation, LargeProblemsAgainstPlainDynamicProgramming) {
  for (int kind = 0; kind < 4; ++kind) {
    AllocationProblem p = random_problem(kind, 300, 5);
    for (const double fraction : {0.0625, 0.07, 0.125, 0.25, 0.5, 0.9}) {
      p.budget = static_cast<std::int64_t>(fraction * 16 * 300);
      SCOPED_TRACE(::testing::Message() << "kind " << kind << ", budget " << p.budget);
      const Allocation exact = allocate(p, AllocationSolver::kExact);
      expect_consistent(p, exact);
      EXPECT_NEAR(exact.total_quality, optimum_by_dynamic_programming(p), rounding(p));
      const Allocation fast = allocate(p, AllocationSolver::kFast);
      expect_consistent(p, fast);
      EXPECT_GE(fast.total_quality,
                allocate(p, AllocationSolver::kGreedy).total_quality - rounding(p));
      EXPECT_GE(fast.total_quality + fast.gap_bound, exact.total_quality - rounding(p));
    }
  }
}

TEST(RateAllocation, OtherCosts) {
  // Without a common divisor, with equal ones, and with a divisor that the budget lacks.
  for (const std::array<int, kShadingRateCount>& cost :
       {std::array<int, kShadingRateCount>{3, 5, 4, 3, 11, 7, 19},
        {2, 2, 2, 2, 2, 2, 2},
        {6, 12, 12, 24, 48, 48, 96},
        {1, 100, 100, 7, 13, 1, 50}}) {
    AllocationProblem p = random_problem(0, 15, 9);
    p.cost = cost;
    for (const int extra : {0, 1, 5, 50, 107, 2000}) {
      p.budget = 15 * cost[0] + extra;
      const double optimum = optimum_by_dynamic_programming(p);
      EXPECT_NEAR(allocate(p, AllocationSolver::kExact).total_quality, optimum, rounding(p));
      for (const AllocationSolver solver : kSolvers) expect_consistent(p, allocate(p, solver));
    }
  }
}

TEST(RateAllocation, TheUnitOfCostDoesNotMatter) {
  AllocationProblem released = random_problem(1, 50, 3);
  released.budget = 190;
  AllocationProblem thesis = released;
  thesis.cost = AllocationProblem::default_costs();
  thesis.budget = 190 * 16 + 15;
  for (const AllocationSolver solver : kSolvers) {
    const Allocation a = allocate(released, solver), b = allocate(thesis, solver);
    EXPECT_EQ(a.choice, b.choice);
    EXPECT_EQ(16 * a.total_cost, b.total_cost);
  }
}

TEST(RateAllocation, QualityRisesWithTheBudget) {
  AllocationProblem p = random_problem(2, 30, 4);
  double before = -1e9;
  for (p.budget = 30; p.budget <= 16 * 30; ++p.budget) {
    const double now = allocate(p, AllocationSolver::kExact).total_quality;
    EXPECT_GE(now, before - rounding(p));
    before = now;
  }
}

TEST(RateAllocation, ImpossibleProblemsAreRefused) {
  for (const AllocationSolver solver : kSolvers) {
    AllocationProblem p = random_problem(0, 12, 1);
    p.budget = 11;
    EXPECT_THAT(error_of([&] { allocate(p, solver); }), HasSubstr("the least that would do is 12"));
    p.budget = 48;
    for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
      AllocationProblem q = p;
      q.quality[2 * kShadingRateCount + 3] = bad;
      EXPECT_THAT(error_of([&] { allocate(q, solver); }), HasSubstr("tile 2 at rate 2x2"));
    }
    AllocationProblem ragged = p;
    ragged.quality.pop_back();
    EXPECT_THAT(error_of([&] { allocate(ragged, solver); }), HasSubstr("seven qualities"));
    EXPECT_THAT(error_of([&] { allocate(AllocationProblem{}, solver); }),
                HasSubstr("one or more tiles"));
    for (const int cost : {0, -3, 2'000'000}) {
      AllocationProblem q = p;
      q.cost[4] = cost;
      EXPECT_THAT(error_of([&] { allocate(q, solver); }), HasSubstr("rate 1x2 costs"));
    }
  }
  EXPECT_THAT(error_of([] { allocation_solver_from_string("best"); }),
              HasSubstr("greedy, exact or fast"));
}

TEST(RateAllocation, BudgetFractions) {
  EXPECT_EQ(budget_px(0.25, 8040), 16 * 32160);
  EXPECT_EQ(budget_px(0.0625, 3), 3 * 16);
  EXPECT_EQ(budget_px(1, 3), 3 * 256);
  for (const double bad : {0.0, 0.06, -1.0, 1.01, std::nan("")})
    EXPECT_THAT(error_of([&] { budget_px(bad, 3); }), HasSubstr("0.0625"));
}

}  // namespace
}  // namespace wheatstone::testing
