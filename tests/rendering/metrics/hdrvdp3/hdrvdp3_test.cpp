#include "rendering/metrics/hdrvdp3.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "../photograph.h"
#include "../vectors.h"
#include "core/random.h"
#include "tests/shared_data.h"

namespace wheatstone {
namespace {

HdrVdp3Options at(double pixels_per_degree) {
  HdrVdp3Options options;
  options.pixels_per_degree = pixels_per_degree;
  return options;
}

RgbImage noisy(const RgbImage& image, double share, std::uint64_t seed = 1) {
  RandomStream random(seed, 0);
  RgbImage out(image.pixels.clone());
  for (cv::Vec3f& p : out.pixels)
    p *= static_cast<float>(std::max(0.0, 1 + share * random.normal()));
  return out;
}

RgbImage blurred(const RgbImage& image, double sigma_px) {
  RgbImage out(image.width(), image.height());
  cv::GaussianBlur(image.pixels, out.pixels, {0, 0}, sigma_px, sigma_px, cv::BORDER_REPLICATE);
  return out;
}

/// Soft discs of three decades of light.
RgbImage scene(int width, int height) {
  RgbImage out(width, height);
  for (int r = 0; r < height; ++r)
    for (int c = 0; c < width; ++c) {
      const double v = std::sin(0.35 * c) * std::cos(0.21 * r) + 0.5 * std::sin(0.05 * (r + c));
      const auto light = static_cast<float>(10 * std::exp(2 * v));
      out.pixels(r, c) = {light, 0.8f * light, 0.6f * light};
    }
  return out;
}

TEST(HdrVdp3, ScoresLikeTheReference) {
  int compared = 0;
  const auto file = read_vectors("hdrvdp3_quality.json");
  for (const auto& c : file["cases"]) {
    const HdrVdp3Result r =
        hdr_vdp3(vector_image(c["test"]), vector_image(c["reference"]), at(c["ppd"]));
    // The vectors have 8 decimals.
    EXPECT_NEAR(r.q, c["Q"].get<double>(), 2e-8) << c;
    EXPECT_NEAR(r.q_jod, c["Q_JOD"].get<double>(), 2e-8) << c;
    EXPECT_NEAR(r.c_max, c["C_max"].get<double>(), 1e-7) << c;
    // The original's probability falls below 0 where nothing differs; ours does not.
    EXPECT_NEAR(r.p_det, std::max(c["P_det"].get<double>(), 0.0), 2e-8) << c;
    ++compared;
  }
  EXPECT_EQ(compared, 28);
}

TEST(HdrVdp3, PhotographLikeTheReference) {
  const auto path = shared_folder("reference/metrics/data/nancy_church.hdr");
  REQUIRE_SHARED(path);
  const Photograph photograph = degraded_photograph(path);
  const auto tests = read_vectors("nancy_church.json")["tests"];
  const std::pair<const char*, RgbImage> images[] = {{"blur", photograph.blur},
                                                     {"contrast80", photograph.contrast80}};
  for (const auto& [name, image] : images) {
    const HdrVdp3Result r = hdr_vdp3(image, photograph.reference, at(45));
    const auto& expected = tests[name]["hdrvdp3_quality_45ppd"];
    EXPECT_NEAR(r.q, expected["Q"].get<double>(), 1e-6) << name;
    EXPECT_NEAR(r.q_jod, expected["Q_JOD"].get<double>(), 1e-6) << name;
    EXPECT_NEAR(r.p_det, expected["P_det"].get<double>(), 1e-6) << name;
  }
}

TEST(HdrVdp3, EqualImagesScoreExactlyTen) {
  // Odd sides, the smallest side, few levels, many levels, and nearly no light.
  const std::pair<RgbImage, double> cases[] = {
      {scene(53, 71), 45}, {scene(13, 13), 45}, {scene(64, 13), 4}, {scene(140, 131), 400}};
  for (const auto& [image, ppd] : cases) {
    const HdrVdp3Result r = hdr_vdp3(image, image, at(ppd));
    EXPECT_EQ(r.q_jod, 10);
    EXPECT_EQ(r.q, 10);
    EXPECT_EQ(r.q_err, 0);
    EXPECT_EQ(r.p_det, 0);
    EXPECT_EQ(r.c_max, 0);
    EXPECT_EQ(cv::countNonZero(r.detection_probability.pixels), 0);
  }
}

TEST(HdrVdp3, QualityFallsWithNoiseAndBlur) {
  const RgbImage image = scene(90, 75);
  double by_noise = 10, by_blur = 10, detected = 0;
  for (const double strength : {0.02, 0.05, 0.1, 0.2, 0.5}) {
    const HdrVdp3Result noise = hdr_vdp3(noisy(image, strength), image, at(40));
    const HdrVdp3Result blur = hdr_vdp3(blurred(image, 0.5 + 4 * strength), image, at(40));
    EXPECT_LT(noise.q_jod, by_noise) << strength;
    EXPECT_LT(blur.q_jod, by_blur) << strength;
    EXPECT_GT(noise.p_det, detected) << strength;
    by_noise = noise.q_jod;
    by_blur = blur.q_jod;
    detected = noise.p_det;
  }
  EXPECT_GT(detected, 0.95);
  EXPECT_LT(by_noise, 8);
}

TEST(HdrVdp3, FinePixelsHideNoise) {
  const RgbImage image = scene(96, 96), test = noisy(image, 0.1);
  double before = 0;
  for (const double ppd : {15.0, 30.0, 60.0, 120.0}) {
    const double jod = hdr_vdp3(test, image, at(ppd)).q_jod;
    EXPECT_GT(jod, before) << ppd;
    before = jod;
  }
}

TEST(HdrVdp3, DimLightHidesNoise) {
  const RgbImage bright = scene(64, 64), bright_test = noisy(bright, 0.1);
  const RgbImage dim(bright.pixels * 1e-4), dim_test(bright_test.pixels * 1e-4);
  EXPECT_GT(hdr_vdp3(dim_test, dim, at(30)).q_jod, hdr_vdp3(bright_test, bright, at(30)).q_jod);
}

TEST(HdrVdp3, RowsAndColumnsCountAlike) {
  const RgbImage image = scene(61, 44), test = noisy(image, 0.1);
  cv::Mat3f image_t, test_t;
  cv::transpose(image.pixels, image_t);
  cv::transpose(test.pixels, test_t);
  const HdrVdp3Result a = hdr_vdp3(test, image, at(45));
  const HdrVdp3Result b = hdr_vdp3(RgbImage(test_t), RgbImage(image_t), at(45));
  EXPECT_NEAR(a.q, b.q, 1e-9);
  EXPECT_NEAR(a.c_max, b.c_max, 1e-9);
  EXPECT_LT(
      cv::norm(a.detection_probability.pixels.t(), b.detection_probability.pixels, cv::NORM_INF),
      1e-6);
}

TEST(HdrVdp3, TheMapShowsWhereTheDifferenceIs) {
  const RgbImage image = scene(160, 120);
  RgbImage test(image.pixels.clone());
  const cv::Rect patch(110, 30, 24, 24);
  cv::Mat3f region = test.pixels(patch);
  cv::GaussianBlur(region, region, {0, 0}, 4);
  const HdrVdp3Result r = hdr_vdp3(test, image, at(45));
  const cv::Mat1f& map = r.detection_probability.pixels;
  ASSERT_EQ(map.size(), image.pixels.size());
  EXPECT_GT(cv::mean(map(patch))[0], 0.8);
  EXPECT_LT(cv::mean(map(cv::Rect(0, 0, 60, 120)))[0], 0.02);
  double least = 0, most = 0;
  cv::minMaxLoc(map, &least, &most);
  EXPECT_GE(least, 0);
  EXPECT_LE(most, 1);
}

TEST(HdrVdp3, SpectraChangeWhatColoursCount) {
  const RgbImage image = scene(48, 48);
  RgbImage test(image.pixels.clone());
  for (int r = 0; r < 48; ++r)
    for (int c = 0; c < 48; c += 2) test.pixels(r, c)[2] *= 1.5f;
  HdrVdp3Options oled = at(30);
  oled.spectra = DisplaySpectra::kOled;
  const double a = hdr_vdp3(test, image, at(30)).q, b = hdr_vdp3(test, image, oled).q;
  EXPECT_GT(std::abs(a - b), 1e-3);
}

TEST(HdrVdp3, SameBytesForEveryNumberOfThreads) {
  const RgbImage image = scene(150, 131), test = noisy(image, 0.1);
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return hdr_vdp3(test, image, at(45));
  };
  const HdrVdp3Result one = run(1);
  for (const std::size_t threads : {2, 3, 8}) {
    const HdrVdp3Result many = run(threads);
    EXPECT_EQ(one.q_err, many.q_err);
    EXPECT_EQ(one.p_det, many.p_det);
    EXPECT_EQ(one.c_max, many.c_max);
    EXPECT_EQ(
        cv::norm(one.detection_probability.pixels, many.detection_probability.pixels, cv::NORM_INF),
        0);
  }
}

TEST(HdrVdp3, ExtremeLightGivesFiniteScores) {
  RgbImage image = scene(40, 30);
  for (const float extreme : {1e-30f, 1e-6f, 1e6f, 3e38f}) {
    RgbImage test(image.pixels.clone());
    for (int c = 0; c < 40; ++c) test.pixels(7, c) = cv::Vec3f::all(extreme);
    const HdrVdp3Result r = hdr_vdp3(test, image, at(45));
    EXPECT_TRUE(std::isfinite(r.q_jod) && std::isfinite(r.c_max)) << extreme;
    EXPECT_LT(r.q_jod, 10) << extreme;
    EXPECT_TRUE(cv::checkRange(r.detection_probability.pixels)) << extreme;
  }
  image.pixels = 0;
  image.pixels(15, 20) = cv::Vec3f::all(3e38f);
  EXPECT_TRUE(std::isfinite(hdr_vdp3(scene(40, 30), image, at(45)).q_jod));
}

}  // namespace
}  // namespace wheatstone
