#include "core/random.h"

#include <gtest/gtest.h>

namespace wheatstone {
namespace {

TEST(Random, SameSeedAndStreamGiveTheSameNumbersAndOthersDoNot) {
  RandomStream a(7, 3), b(7, 3), other_stream(7, 4), other_seed(8, 3);
  const auto first = a.next();
  EXPECT_EQ(first, b.next());
  EXPECT_NE(first, other_stream.next());
  EXPECT_NE(first, other_seed.next());
}

TEST(Random, NormalHasZeroMeanAndUnitVariance) {
  RandomStream s(1, 0);
  double sum = 0, squares = 0;
  constexpr int kN = 200000;
  for (int i = 0; i < kN; ++i) {
    const double x = s.normal();
    sum += x;
    squares += x * x;
  }
  EXPECT_NEAR(sum / kN, 0, 4 / std::sqrt(kN));
  EXPECT_NEAR(squares / kN, 1, 4 * std::sqrt(2.0 / kN));
}

TEST(Random, PoissonHasEqualMeanAndVarianceBelowAndAboveTheSwitch) {
  for (const double mean : {0.5, 5.0, 29.0, 31.0, 1000.0}) {
    RandomStream s(2, static_cast<std::uint64_t>(mean * 10));
    constexpr int kN = 50000;
    double sum = 0, squares = 0;
    for (int i = 0; i < kN; ++i) {
      const double x = s.poisson(mean);
      sum += x;
      squares += x * x;
    }
    const double m = sum / kN;
    EXPECT_NEAR(m, mean, 5 * std::sqrt(mean / kN));
    EXPECT_NEAR((squares / kN - m * m) / mean, 1, 0.05) << mean;
  }
}

}  // namespace
}  // namespace wheatstone
