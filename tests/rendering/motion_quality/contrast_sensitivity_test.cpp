#include "rendering/motion_quality/contrast_sensitivity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "vectors.h"

namespace wheatstone {
namespace {

constexpr double kTolerance = 1e-9;  // relative, as the vectors ask

void expect_close(double value, double expected, const std::string& where) {
  if (std::isnan(expected))
    EXPECT_TRUE(std::isnan(value)) << where;
  else
    EXPECT_NEAR(value, expected, kTolerance * std::abs(expected)) << where;
}

TEST(ContrastSensitivity, BartenLikeTheReference) {
  const CsvTable t = read_vectors("csf_barten.csv");
  ASSERT_GT(t.rows(), 0u);
  for (std::size_t i = 0; i < t.rows(); ++i)
    expect_close(barten_csf(t.number(i, "u_cpd"), t.number(i, "L_cd_m2"), t.number(i, "X0_deg")),
                 t.number(i, "S"), t.where(i));
}

TEST(ContrastSensitivity, KellyLikeTheReference) {
  const CsvTable t = read_vectors("csf_kelly_released.csv");
  ASSERT_GT(t.rows(), 0u);
  for (std::size_t i = 0; i < t.rows(); ++i)
    expect_close(kelly_csf(t.number(i, "rho_cpd"), t.number(i, "omega_hz")),
                 t.number(i, "S_released"), t.where(i));
}

TEST(ContrastSensitivity, VelocityLikeTheReference) {
  const CsvTable t = read_vectors("csf_daly.csv");
  ASSERT_GT(t.rows(), 0u);
  for (std::size_t i = 0; i < t.rows(); ++i)
    expect_close(velocity_csf(t.number(i, "rho_cpd"), t.number(i, "velocity_deg_s")),
                 t.number(i, "S"), t.where(i));
}

TEST(ContrastSensitivity, SpatiotemporalLikeTheReference) {
  const CsvTable t = read_vectors("csf_spatiotemporal.csv");
  ASSERT_GT(t.rows(), 0u);
  for (std::size_t i = 0; i < t.rows(); ++i) {
    const double rho = t.number(i, "rho_cpd"), omega = t.number(i, "omega_hz"),
                 luminance = t.number(i, "L_cd_m2");
    expect_close(static_csf(rho, luminance), t.number(i, "S_static"), t.where(i));
    expect_close(velocity_csf_ratio(rho, omega), t.number(i, "S_daly_ratio"), t.where(i));
    expect_close(spatiotemporal_csf(rho, omega, luminance), t.number(i, "S"), t.where(i));
  }
}

// Sensitivities at 0 cpd must be their limits, not a division of two zeros.
TEST(ContrastSensitivity, ZeroFrequencyIsTheLimit) {
  EXPECT_EQ(barten_csf(0, 100, 10), 0);
  EXPECT_LT(barten_csf(1e-9, 100, 10), 1e-3);
  for (const double omega : {0.0, 1.0, 60.0}) {
    EXPECT_EQ(kelly_csf(0, omega), 0) << omega;
    EXPECT_LT(kelly_csf(1e-9, omega), 1e-2) << omega;
  }
  for (const double velocity : {0.0, 0.3, 100.0}) EXPECT_EQ(velocity_csf(0, velocity), 0);
  EXPECT_EQ(static_csf(0, 100), 0);
  EXPECT_LT(static_csf(1e-9, 100), 1e-3);
  EXPECT_EQ(spatiotemporal_csf(0, 0, 100), 0);
  EXPECT_TRUE(std::isnan(spatiotemporal_csf(0, 60, 100)));
}

TEST(ContrastSensitivity, WithoutMotionTheTemporalPartIsOne) {
  for (double rho = 0.25; rho < 32; rho *= 2) {
    EXPECT_NEAR(velocity_csf_ratio(rho, 0), 1, 1e-4) << rho;
    EXPECT_NEAR(spatiotemporal_csf(rho, 0, 100) / static_csf(rho, 100), 1, 1e-4) << rho;
  }
}

TEST(ContrastSensitivity, ImpossibleArgumentsAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {-1.0, nan, infinity}) {
    EXPECT_THROW(barten_csf(bad, 100, 10), ArgumentError);
    EXPECT_THROW(kelly_csf(bad, 60), ArgumentError);
    EXPECT_THROW(kelly_csf(1, bad), ArgumentError);
    EXPECT_THROW(velocity_csf(bad, 1), ArgumentError);
    EXPECT_THROW(velocity_csf(1, bad), ArgumentError);
    EXPECT_THROW(static_csf(bad, 100), ArgumentError);
    EXPECT_THROW(velocity_csf_ratio(0, bad), ArgumentError);
    EXPECT_THROW(spatiotemporal_csf(1, bad, 100), ArgumentError);
  }
  for (const double bad : {0.0, -1.0, nan, infinity}) {
    EXPECT_THROW(barten_csf(1, bad, 10), ArgumentError);
    EXPECT_THROW(barten_csf(1, 100, bad), ArgumentError);
    EXPECT_THROW(static_csf(1, bad), ArgumentError);
    EXPECT_THROW(spatiotemporal_csf(1, 60, bad), ArgumentError);
  }
}

}  // namespace
}  // namespace wheatstone
