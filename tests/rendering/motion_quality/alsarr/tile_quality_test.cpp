#include "rendering/motion_quality/alsarr/tile_quality.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/csv.h"
#include "core/error.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/random.h"
#include "rendering/motion_quality/alsarr/rate_allocation.h"
#include "tests/error_text.h"
#include "tests/shared_data.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using testing::HasSubstr;

/// The sample frame with the reference's synthetic luminance.
TileBuffers sample_frame(const std::filesystem::path& reference) {
  TileBuffers b = read_tile_buffers({reference / "sample_frame/motion_n.exr",
                                     reference / "sample_frame/materials_n.exr",
                                     {},
                                     100},
                                    {1920, 1080, 60, 60});
  for (int y = 0; y < b.tiles_y(); ++y)
    for (int x = 0; x < b.tiles_x(); ++x)
      b.luminance_cd_m2(y, x) = std::pow(10, -1 + 3.4 * ((7 * x + 13 * y) % 101) / 100.0) + 0.01;
  return b;
}

TEST(SampleFrame, QualitiesAndAllocationsLikeTheReference) {
  const auto reference = shared_folder("reference/perception");
  REQUIRE_SHARED(reference);
  const TileBuffers buffers = sample_frame(reference);
  const PolynomialTable table = PolynomialTable::read(reference / "vectors/sample_polynomials.csv");
  AllocationProblem problem;
  problem.quality = TileQualityModel(table, 60).evaluate(buffers);

  const CsvTable expected = CsvTable::read(reference / "vectors/sample_frame_vrs.csv");
  ASSERT_EQ(expected.rows(), problem.tiles());
  std::vector<std::uint8_t> greedy_choice;
  for (std::size_t tile = 0; tile < problem.tiles(); ++tile) {
    const int x = static_cast<int>(expected.number(tile, "tile_x"));
    const int y = static_cast<int>(expected.number(tile, "tile_y"));
    ASSERT_EQ(tile, static_cast<std::size_t>(x * buffers.tiles_y() + y));
    EXPECT_NEAR(buffers.speed_x_deg_per_s(y, x), expected.number(tile, "velocity_x_deg_s"), 1e-7);
    EXPECT_NEAR(buffers.speed_y_deg_per_s(y, x), expected.number(tile, "velocity_y_deg_s"), 1e-7);
    EXPECT_NEAR(buffers.luminance_cd_m2(y, x), expected.number(tile, "luminance_cd_m2"), 1e-7);
    EXPECT_EQ(buffers.material(y, x) + 1, expected.number(tile, "material_index"));
    for (int k = 0; k < kShadingRateCount; ++k)
      EXPECT_NEAR(problem.quality[tile * kShadingRateCount + k],
                  expected.number(tile, std::string("q_") + kShadingRates[k].name), 1e-11)
          << expected.where(tile);
    greedy_choice.push_back(static_cast<std::uint8_t>(expected.number(tile, "greedy_choice")));
  }

  const auto summary =
      nlohmann::json::parse(read_text(reference / "vectors/sample_frame_vrs_summary.json"));
  problem.budget = budget_px(0.25, problem.tiles());
  ASSERT_EQ(problem.budget, 16 * summary["budget"].get<std::int64_t>());
  const Allocation greedy = allocate(problem, AllocationSolver::kGreedy);
  EXPECT_EQ(greedy.choice, greedy_choice);
  EXPECT_NEAR(greedy.total_quality, summary["greedy_quality"].get<double>(), 1e-6);
  EXPECT_EQ(greedy.total_cost, 16 * summary["greedy_bandwidth"].get<std::int64_t>());
  const Allocation exact = allocate(problem, AllocationSolver::kExact);
  EXPECT_NEAR(exact.total_quality, summary["exact_optimum"].get<double>(), 1e-6);

  for (const double fraction : {0.0625, 0.125, 0.25, 0.5}) {
    problem.budget = budget_px(fraction, problem.tiles());
    const double optimum = allocate(problem, AllocationSolver::kExact).total_quality;
    const Allocation fast = allocate(problem, AllocationSolver::kFast);
    EXPECT_LE(fast.total_cost, problem.budget);
    EXPECT_GE(fast.total_quality, optimum * (1 - 0.0005)) << fraction;
    EXPECT_GE(fast.total_quality + fast.gap_bound, optimum - 1e-9);
  }
}

TEST(SampleFrame, TheSecondCopyIsTheSame) {
  const auto reference = shared_folder("reference/perception/sample_frame");
  const auto data = shared_folder("data/gbuffer_alsarr");
  REQUIRE_SHARED(reference);
  REQUIRE_SHARED(data);
  const TileBuffers a =
      read_tile_buffers({reference / "motion_n.exr", reference / "materials_n.exr", {}, 100}, {});
  const TileBuffers b =
      read_tile_buffers({data / "motion_n.exr", data / "materials_n.exr", {}, 100}, {});
  EXPECT_EQ(cv::norm(a.speed_x_deg_per_s, b.speed_x_deg_per_s), 0);
  EXPECT_EQ(cv::norm(a.material, b.material), 0);
}

PolynomialTable random_table(int materials, std::uint64_t seed) {
  RandomStream random(seed, 0);
  std::vector<PolynomialTable::Material> out(static_cast<std::size_t>(materials));
  for (auto& material : out)
    for (auto& mip : material.mips)
      for (auto& polynomial : mip)
        for (double& w : polynomial.w) w = 0.01 * random.normal();
  return PolynomialTable(out);
}

TileBuffers random_buffers(int tiles_x, int tiles_y, int materials, std::uint64_t seed) {
  RandomStream random(seed, 1);
  const cv::Size size(tiles_x, tiles_y);
  TileBuffers b{cv::Mat1d(size), cv::Mat1d(size), cv::Mat1i(size), cv::Mat1i(size),
                cv::Mat1d(size)};
  for (int y = 0; y < tiles_y; ++y)
    for (int x = 0; x < tiles_x; ++x) {
      b.speed_x_deg_per_s(y, x) = 50 * random.uniform();
      b.speed_y_deg_per_s(y, x) = 50 * random.uniform();
      b.material(y, x) = static_cast<int>(random.next() % static_cast<std::uint64_t>(materials));
      b.mip_level(y, x) = static_cast<int>(random.next() % 15);
      b.luminance_cd_m2(y, x) = std::pow(10, -2 + 5 * random.uniform());
    }
  return b;
}

TEST(TileQuality, IsTheMeanOfBothAxesAsPrinted) {
  const PolynomialTable table = random_table(4, 2);
  const TileBuffers b = random_buffers(9, 5, 4, 2);
  const std::vector<double> quality = TileQualityModel(table, 85).evaluate(b);
  for (int x = 0; x < 9; ++x)
    for (int y = 0; y < 5; ++y)
      for (int k = 0; k < kShadingRateCount; ++k) {
        const PolynomialTable::MipRow& row = table.at(b.material(y, x), b.mip_level(y, x));
        const auto axis = [&](int block_px, double speed) {
          if (block_px == 4) return 0.0;
          const auto rate =
              static_cast<std::size_t>(block_px == 2 ? AxisRate::kHalf : AxisRate::kFull);
          return row[rate](speed, 85, b.luminance_cd_m2(y, x));
        };
        const double expected = (axis(kShadingRates[k].width_px, b.speed_x_deg_per_s(y, x)) +
                                 axis(kShadingRates[k].height_px, b.speed_y_deg_per_s(y, x))) /
                                    2 +
                                0.1;
        EXPECT_NEAR(quality[static_cast<std::size_t>(x * 5 + y) * kShadingRateCount + k], expected,
                    1e-12 * (1 + std::abs(expected)));
      }
}

TEST(TileQuality, ImpossibleBuffersAreRefused) {
  const PolynomialTable table = random_table(4, 2);
  const TileQualityModel model(table, 60);
  const TileBuffers good = random_buffers(6, 4, 4, 3);
  const auto with = [&](auto change) {
    TileBuffers b = good;
    b.speed_x_deg_per_s = good.speed_x_deg_per_s.clone();
    b.material = good.material.clone();
    b.mip_level = good.mip_level.clone();
    b.luminance_cd_m2 = good.luminance_cd_m2.clone();
    change(b);
    return error_of([&] { model.evaluate(b); });
  };
  EXPECT_EQ(with([](TileBuffers&) {}), "no error");
  EXPECT_THAT(with([](TileBuffers& b) { b.material(3, 5) = 4; }),
              testing::AllOf(HasSubstr("tile (5, 3) has material 4"), HasSubstr("table has 4")));
  EXPECT_THAT(with([](TileBuffers& b) { b.material(3, 5) = -1; }), HasSubstr("tile (5, 3) is -1"));
  EXPECT_THAT(with([](TileBuffers& b) { b.mip_level(0, 1) = -1; }), HasSubstr("mip level"));
  EXPECT_THAT(with([](TileBuffers& b) { b.speed_x_deg_per_s(0, 1) = -1; }), HasSubstr("x speed"));
  EXPECT_THAT(with([](TileBuffers& b) {
                b.speed_x_deg_per_s(0, 1) = std::numeric_limits<double>::quiet_NaN();
              }),
              HasSubstr("x speed"));
  EXPECT_THAT(with([](TileBuffers& b) { b.luminance_cd_m2(0, 1) = 0; }), HasSubstr("luminance"));
  EXPECT_THAT(with([](TileBuffers& b) { b.luminance_cd_m2 = cv::Mat1d(4, 5, 1.0); }),
              HasSubstr("luminance buffer has 5x4 tiles, the material buffer 6x4"));
  EXPECT_THAT(with([](TileBuffers& b) { b = {}; }), HasSubstr("without tiles"));
  EXPECT_THAT(error_of([&] { TileQualityModel(table, 0); }), HasSubstr("refresh rate"));
  EXPECT_THAT(error_of([&] { TileQualityModel(PolynomialTable(), 60); }), HasSubstr("materials"));
  EXPECT_THAT(error_of([&] { good.part({3, 2, 4, 1}); }), HasSubstr("do not lie in 6x4"));
}

/// R and G of an EXR file; B stays 0.
void write_two_channels(const std::filesystem::path& path, const cv::Mat1f& r, const cv::Mat1f& g) {
  RgbImage image(r.cols, r.rows);
  for (int y = 0; y < r.rows; ++y)
    for (int x = 0; x < r.cols; ++x) image.pixels(y, x) = {r(y, x), g(y, x), 0};
  write_exr(path, image);
}

class TileBufferFile : public testing::Test {
 protected:
  TileBufferFile() {
    write_two_channels(files_.motion, cv::Mat1f(3, 4, 0.5F), cv::Mat1f(3, 4, 0.25F));
    write_two_channels(files_.materials, cv::Mat1f(3, 4, 7.0F), cv::Mat1f(3, 4, 2.0F));
  }
  std::string error() {
    return error_of([&] { read_tile_buffers(files_, {1000, 500, 60, 30}); });
  }

  TemporaryFolder folder_;
  TileBufferFiles files_{folder_.path / "motion.exr", folder_.path / "materials.exr", {}, 100};
};

TEST_F(TileBufferFile, MotionBecomesDegreesPerSecond) {
  const TileBuffers b = read_tile_buffers(files_, {1000, 500, 60, 30});
  EXPECT_EQ(b.tiles_x(), 4);
  EXPECT_EQ(b.tiles_y(), 3);
  EXPECT_DOUBLE_EQ(b.speed_x_deg_per_s(2, 3), 0.5 * 1000 * 60 / 30 / 100);
  EXPECT_DOUBLE_EQ(b.speed_y_deg_per_s(2, 3), 0.25 * 500 * 60 / 30 / 100);
  EXPECT_EQ(b.material(0, 0), 7);
  EXPECT_EQ(b.mip_level(0, 0), 2);
  EXPECT_EQ(b.luminance_cd_m2(0, 0), 100);
}

TEST_F(TileBufferFile, ImpossibleFilesAreRefused) {
  EXPECT_EQ(error(), "no error");
  write_two_channels(files_.materials, cv::Mat1f(3, 5, 7.0F), cv::Mat1f(3, 5, 2.0F));
  EXPECT_THAT(error(), testing::AllOf(HasSubstr("materials.exr"), HasSubstr("has 5x3 tiles")));
  write_two_channels(files_.materials, cv::Mat1f(3, 4, 7.5F), cv::Mat1f(3, 4, 2.0F));
  EXPECT_THAT(error(), HasSubstr("the material of tile (0, 0) is 7.5"));
  write_exr(files_.materials, ScalarImage(4, 3, 1), "Y");
  EXPECT_THAT(error(), testing::AllOf(HasSubstr("materials.exr"), HasSubstr("no channel 'R'")));
  write_text_atomically(files_.materials, "no picture at all");
  EXPECT_THAT(error(), HasSubstr("materials.exr"));
  std::filesystem::remove(files_.materials);
  EXPECT_THAT(error(), testing::AllOf(HasSubstr("materials.exr"), HasSubstr("no such file")));
  EXPECT_THAT(error_of([&] {
                read_tile_buffers(files_, {1000, 500, 60, 0});
              }),
              HasSubstr("pixels per degree"));
}

TEST(TileLuminance, IsTheMeanOverTheTilePlusTheOffset) {
  RgbImage image(40, 20);  // three by two tiles, the last ones partial
  image.pixels.setTo(cv::Scalar::all(50));
  image.pixels(cv::Rect(32, 16, 8, 4)).setTo(cv::Scalar::all(200));
  const cv::Mat1d luminance = tile_luminance_cd_m2(image);
  ASSERT_EQ(luminance.size(), cv::Size(3, 2));
  EXPECT_NEAR(luminance(0, 0), 50.01, 1e-4);
  EXPECT_NEAR(luminance(1, 2), 200.01, 1e-4);
  EXPECT_NEAR(luminance(1, 1), 50.01, 1e-4);
  EXPECT_THROW(tile_luminance_cd_m2(RgbImage()), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
