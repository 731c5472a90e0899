#include "rendering/metrics/hdrvdp3/steerable_pyramid.h"

#include <gtest/gtest.h>

#include <fstream>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "planes.h"
#include "tests/shared_data.h"

namespace wheatstone {
namespace {

/// The table of filter taps as published: numbers only, no header.
cv::Mat1d read_taps(const std::filesystem::path& path) {
  std::ifstream in(path);
  cv::Mat1d taps;
  for (std::string line; std::getline(in, line);) {
    std::vector<double> row;
    std::stringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
    taps.push_back(cv::Mat1d(row, true).reshape(1, 1));
  }
  return taps;
}

cv::Mat1d correlate(const cv::Mat1d& image, const cv::Mat1d& taps) {
  cv::Mat1d out;
  cv::filter2D(image, out, -1, taps, {-1, -1}, 0, cv::BORDER_REFLECT_101);
  return out;
}

cv::Mat1d even_samples(const cv::Mat1d& image) {
  cv::Mat1d out((image.rows + 1) / 2, (image.cols + 1) / 2);
  for (int r = 0; r < out.rows; ++r)
    for (int c = 0; c < out.cols; ++c) out(r, c) = image(2 * r, 2 * c);
  return out;
}

TEST(SteerablePyramid, BandsAreThePublishedFilters) {
  const auto folder = shared_folder("reference/metrics/data");
  REQUIRE_SHARED(folder);
  const auto taps = [&](const std::string& name) {
    return read_taps(folder / ("steerable_sp0_" + name + ".csv"));
  };
  for (const cv::Size size : {cv::Size(64, 52), cv::Size(53, 71)}) {
    const cv::Mat1d image = random_plane(size);
    const std::vector<cv::Mat1d> bands = steerable_bands(image, 2);
    const cv::Mat1d low0 = correlate(image, taps("lo0"));
    const cv::Mat1d low1 = even_samples(correlate(low0, taps("lo")));
    const cv::Mat1d low2 = even_samples(correlate(low1, taps("lo")));
    ASSERT_EQ(bands.size(), 4u);
    EXPECT_LT(largest_difference(bands[0], correlate(image, taps("hi0"))), 1e-10);
    EXPECT_LT(largest_difference(bands[1] * 2, correlate(low0, taps("bf"))), 1e-10);
    EXPECT_LT(largest_difference(bands[2] * 4, correlate(low1, taps("bf"))), 1e-10);
    EXPECT_LT(largest_difference(bands[3] * 8, low2), 1e-10);
  }
}

TEST(SteerablePyramid, LevelsFitTheFiltersAndTheResolution) {
  EXPECT_EQ(steerable_levels({1000, 1000}, 45), 4);
  EXPECT_EQ(steerable_levels({1000, 1000}, 30), 3);
  EXPECT_EQ(steerable_levels({1000, 1000}, 32), 3);
  EXPECT_EQ(steerable_levels({1000, 1000}, 4), 0);
  EXPECT_EQ(steerable_levels({13, 1000}, 45), 1);
  EXPECT_EQ(steerable_levels({1000, 26}, 45), 2);
  EXPECT_EQ(steerable_levels({51, 51}, 400), 2);
  EXPECT_DOUBLE_EQ(band_frequency_cpd(0, 45), 22.5);
  EXPECT_DOUBLE_EQ(band_frequency_cpd(5, 45), 0.703125);
}

TEST(SteerablePyramid, AGratingFallsIntoItsOctave) {
  const std::pair<double, int> gratings[] = {{0.45, 0}, {0.088, 2}, {0.044, 3}, {0.022, 4}};
  for (const auto& [cycles_per_px, expected] : gratings) {
    cv::Mat1d grating(128, 128);
    for (int r = 0; r < 128; ++r)
      for (int c = 0; c < 128; ++c)
        grating(r, c) = std::cos(2 * std::numbers::pi * cycles_per_px * c);
    std::vector<double> mean_square;
    for (const cv::Mat1d& band : steerable_bands(grating, 4))
      mean_square.push_back(cv::norm(band, cv::NORM_L2SQR) / static_cast<double>(band.total()));
    const auto strongest = std::max_element(mean_square.begin(), mean_square.end());
    EXPECT_EQ(strongest - mean_square.begin(), expected) << cycles_per_px;
  }
}

TEST(SteerablePyramid, BandsAddUpToTheImage) {
  // The filters are not perfect: their responses add up to 1 within 5 %.
  for (const cv::Size size : {cv::Size(96, 64), cv::Size(95, 61), cv::Size(13, 14)}) {
    const cv::Mat1d image = random_plane(size);
    const int levels = steerable_levels(size, 45);
    const cv::Mat1d back = reconstruct_from_bands(steerable_bands(image, levels));
    EXPECT_LT(cv::norm(back, image), 0.05 * cv::norm(image)) << size;
    const cv::Mat1d constant(size, 5.0);
    EXPECT_LT(
        largest_difference(reconstruct_from_bands(steerable_bands(constant, levels)), constant),
        0.05 * 5)
        << size;
  }
}

}  // namespace
}  // namespace wheatstone
