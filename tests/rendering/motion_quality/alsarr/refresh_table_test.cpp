#include "rendering/motion_quality/alsarr/refresh_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <map>

#include "core/error.h"
#include "rendering/motion_quality/grey_texture.h"
#include "tests/rendering/motion_quality/vectors.h"
#include "tests/shared_data.h"

namespace wheatstone {
namespace {

using testing::HasSubstr;

TEST(RefreshTable, SampleFrameLikeTheReference) {
  const auto snapshot = shared_folder("reference/perception/sample_frame/scene_snapshot.png");
  REQUIRE_SHARED(snapshot);
  const double fractions[] = {0.0625, 0.25}, speeds[] = {0, 12.5, 25, 37.5, 50};
  const RefreshTable table(Camojab(CamojabTexture(read_grey_texture(snapshot))), fractions, speeds);

  const CsvTable grid = read_vectors("refresh_lut_grid.csv");
  std::map<std::array<double, 3>, double> reference_quality;
  ASSERT_EQ(table.candidates().size(), grid.rows());
  for (std::size_t row = 0; row < grid.rows(); ++row) {
    const RefreshCandidate& c = table.candidates()[row];
    EXPECT_EQ(c.budget_fraction, grid.number(row, "bandwidth_fraction"));
    EXPECT_EQ(c.speed_deg_per_s, grid.number(row, "velocity_deg_s"));
    EXPECT_EQ(c.refresh_hz, grid.number(row, "refresh_hz"));
    EXPECT_NEAR(c.resolution_reduction, grid.number(row, "resolution_reduction"), 1e-12);
    EXPECT_NEAR(c.quality, grid.number(row, "Q"), 1e-4) << grid.where(row);
    reference_quality[{c.budget_fraction, c.speed_deg_per_s, c.refresh_hz}] = grid.number(row, "Q");
  }
  const CsvTable chosen = read_vectors("refresh_lut.csv");
  ASSERT_EQ(table.entries().size(), chosen.rows());
  for (std::size_t row = 0; row < chosen.rows(); ++row) {
    // Optima are flat: what counts is the quality reached.
    const RefreshEntry& e = table.entries()[row];
    EXPECT_NEAR(reference_quality.at({e.budget_fraction, e.speed_deg_per_s, e.best_refresh_hz}),
                reference_quality.at(
                    {e.budget_fraction, e.speed_deg_per_s, chosen.number(row, "best_refresh_hz")}),
                1e-4)
        << chosen.where(row);
  }
}

class SmallRefreshTable : public testing::Test {
 protected:
  const Camojab camojab_{CamojabTexture(procedural_texture("noise128"))};
  const std::vector<double> fractions_ = {0.125, 0.5}, speeds_ = {0, 20};
  const RefreshSearch search_{40, 120, 40, 45, 100, 1, 0};
};

TEST_F(SmallRefreshTable, IsTheSameForAnyNumberOfThreads) {
  const RefreshTable parallel(camojab_, fractions_, speeds_, search_);
  tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const RefreshTable serial(camojab_, fractions_, speeds_, search_);
  ASSERT_EQ(parallel.candidates().size(), 2u * 2 * 3);
  for (std::size_t i = 0; i < serial.candidates().size(); ++i)
    EXPECT_EQ(parallel.candidates()[i].quality, serial.candidates()[i].quality);
}

TEST_F(SmallRefreshTable, ImpossibleResolutionsAreNotChosen) {
  const RefreshTable table(camojab_, fractions_, speeds_, search_);
  for (const RefreshCandidate& c : table.candidates())
    EXPECT_EQ(c.quality == -100, c.resolution_reduction > 1.001);
  for (const RefreshEntry& e : table.entries())
    EXPECT_LE(e.budget_fraction * 120 / e.best_refresh_hz, 1.002);
}

TEST_F(SmallRefreshTable, NearestEntry) {
  const RefreshTable table(camojab_, fractions_, speeds_, search_);
  EXPECT_EQ(&table.nearest(0.4, 9.9), &table.entries()[2]);
  EXPECT_EQ(&table.nearest(0.4, 1000), &table.entries()[3]);
  EXPECT_THROW(table.nearest(0.4, -1), ArgumentError);
  EXPECT_THROW(table.nearest(0.4, std::nan("")), ArgumentError);
}

TEST_F(SmallRefreshTable, ImpossibleArgumentsAreRefused) {
  const auto error_of = [&](const std::vector<double>& fractions, const std::vector<double>& speeds,
                            const RefreshSearch& search) -> std::string {
    try {
      RefreshTable(camojab_, fractions, speeds, search);
    } catch (const ArgumentError& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_THAT(error_of({}, speeds_, search_), HasSubstr("without budgets"));
  EXPECT_THAT(error_of({0}, speeds_, search_), HasSubstr("budget of 0"));
  EXPECT_THAT(error_of({1.5}, speeds_, search_), HasSubstr("budget of 1.5"));
  EXPECT_THAT(error_of({0.5}, {-1}, search_), HasSubstr("speed"));
  RefreshSearch backwards = search_;
  backwards.max_refresh_hz = 20;
  EXPECT_THAT(error_of({0.5}, {1}, backwards), HasSubstr("40 to 20 Hz"));
  RefreshSearch standing = search_;
  standing.step_hz = 0;
  EXPECT_THAT(error_of({0.5}, {1}, standing), HasSubstr("steps of 0"));
}

TEST(FrameSpeed, IsTheMeanMagnitude) {
  const cv::Size size(2, 1);
  TileBuffers b{cv::Mat1d(size, 3.0), cv::Mat1d(size, 4.0), cv::Mat1i(size, 0), cv::Mat1i(size, 0),
                cv::Mat1d(size, 1.0)};
  b.speed_x_deg_per_s(0, 0) = b.speed_y_deg_per_s(0, 0) = 0;
  EXPECT_DOUBLE_EQ(frame_speed_deg_per_s(b), 2.5);
}

}  // namespace
}  // namespace wheatstone
