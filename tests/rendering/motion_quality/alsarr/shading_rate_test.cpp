#include "rendering/motion_quality/alsarr/shading_rate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/exr.h"
#include "core/files.h"
#include "core/random.h"
#include "tests/error_text.h"
#include "tests/temporary_folder.h"

namespace wheatstone {
namespace {

using testing::HasSubstr;

TEST(ShadingRate, CostsAreShadesPerTile) {
  EXPECT_EQ(shading_rate_index("4x4"), 1);
  EXPECT_EQ(shading_rate_index("1x1"), 7);
  int expected[] = {16, 32, 32, 64, 128, 128, 256};
  for (int i = 0; i < kShadingRateCount; ++i) EXPECT_EQ(kShadingRates[i].cost_px(), expected[i]);
  EXPECT_THAT(error_of([] { shading_rate_index("3x3"); }),
              testing::AllOf(HasSubstr("'3x3'"), HasSubstr("4x4, 2x4, 4x2")));
}

TEST(ShadingRateMap, TilesAreNumberedColumnByColumn) {
  const ShadingRateMap map = shading_rate_map({1, 2, 3, 4, 5, 6}, 3, 2);
  EXPECT_EQ(map.rate_index(1, 0), 2);
  EXPECT_EQ(map.rate_index(0, 1), 3);
  EXPECT_EQ(map.cost_px(), 16 + 32 + 32 + 64 + 128 + 128);
  EXPECT_STREQ(map.at_pixel(15, 16).name, "2x4");
  EXPECT_STREQ(map.at_pixel(16, 15).name, "4x2");
  EXPECT_STREQ(map.at_pixel(1000, 1000).name, "2x1");  // beyond: the nearest tile
}

TEST(ShadingRateMap, ReadsBackWhatItWrites) {
  RandomStream random(1, 0);
  std::vector<std::uint8_t> choice(120 * 68);
  for (auto& c : choice) c = static_cast<std::uint8_t>(1 + random.next() % 7);
  const ShadingRateMap map = shading_rate_map(choice, 120, 68);
  write_shading_rate_map(temporary_file("rates.exr"), map);
  const ShadingRateMap back = read_shading_rate_map(temporary_file("rates.exr"));
  ASSERT_EQ(back.rate_index.size(), map.rate_index.size());
  EXPECT_EQ(cv::norm(back.rate_index, map.rate_index, cv::NORM_INF), 0);
}

TEST(ShadingRateMap, OtherContentIsRefused) {
  EXPECT_THAT(error_of([] {
                shading_rate_map({1, 2, 8, 4}, 2, 2);
              }),
              HasSubstr("tile (1, 0) has rate index 8"));
  EXPECT_THAT(error_of([] { shading_rate_map({1, 2, 3}, 2, 2); }), HasSubstr("3 rates for 2x2"));
  for (const float bad : {0.0f, 8.0f, 2.5f, std::nanf("")}) {
    ScalarImage image(4, 3, 1);
    image.pixels(2, 1) = bad;
    write_exr(temporary_file("bad_rates.exr"), image, "rate");
    EXPECT_THAT(error_of([] { read_shading_rate_map(temporary_file("bad_rates.exr")); }),
                testing::AllOf(HasSubstr("bad_rates.exr"), HasSubstr("tile (1, 2)")));
  }
  write_exr(temporary_file("no_rates.exr"), ScalarImage(4, 3, 1), "Y");
  EXPECT_THAT(error_of([] { read_shading_rate_map(temporary_file("no_rates.exr")); }),
              HasSubstr("no channel 'rate'"));
}

TEST(ShadingRateMap, DamagedFilesAreErrors) {
  write_shading_rate_map(temporary_file("good.exr"), shading_rate_map({1, 2, 3, 4, 5, 6}, 3, 2));
  const std::vector<std::byte> good = read_bytes(temporary_file("good.exr"));
  int errors = 0;
  for (std::uint64_t i = 0; i < 150; ++i) {
    RandomStream random(7, i);
    std::vector<std::byte> bytes = good;
    for (std::uint64_t k = 0; k < 1 + random.next() % 4; ++k)
      bytes[random.next() % bytes.size()] ^= std::byte(1u << random.next() % 8);
    if (random.next() % 4 == 0) bytes.resize(random.next() % bytes.size());
    write_bytes_atomically(temporary_file("fuzz.exr"), bytes);
    try {
      const ShadingRateMap map = read_shading_rate_map(temporary_file("fuzz.exr"));
      EXPECT_GE(map.cost_px(), 16);
    } catch (const Error&) {
      ++errors;
    }
  }
  EXPECT_GT(errors, 30);
}

}  // namespace
}  // namespace wheatstone
