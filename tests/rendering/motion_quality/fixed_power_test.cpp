#include "rendering/motion_quality/fixed_power.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/random.h"

namespace wheatstone {
namespace {

TEST(FixedPower, IsThePowerToAFewUnitsInTheLastPlace) {
  RandomStream random(3, 1);
  for (const double beta : {0.05, 0.359663511318103, 1.0, 1.83564, 4.0}) {
    const FixedPower power(beta);
    const auto expect_close = [&](double x) {
      const long double exact = std::pow(static_cast<long double>(x), beta);
      EXPECT_LE(std::abs(power(x) - exact), 4 * std::numeric_limits<double>::epsilon() * exact)
          << x << " ^ " << beta;
    };
    for (int i = 0; i < 20000; ++i) expect_close(std::exp2(140 * random.uniform() - 100));
    for (int e = -240; e < 240; e += 10) expect_close(std::exp2(e));
  }
}

TEST(FixedPower, ZeroStaysZero) {
  const FixedPower power(0.36);
  EXPECT_EQ(power(0.0), 0.0);
  EXPECT_EQ(power(std::numeric_limits<double>::denorm_min()), 0.0);
  EXPECT_GT(power(std::numeric_limits<double>::min()), 0.0);
}

}  // namespace
}  // namespace wheatstone
