#include "capture/response_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iostream>
#include <opencv2/imgcodecs.hpp>

#include "core/error.h"
#include "core/png.h"
#include "core/random.h"
#include "tests/shared_data.h"

namespace wheatstone {
namespace {

/// Codes of a gamma curve with a toe, of random light over five decades.
EncodedStack synthetic(std::vector<double> times_s) {
  EncodedStack out;
  RandomStream random(2, 0);
  cv::Mat1d light(64, 96);
  for (double& v : light) v = std::pow(10, 5 * random.uniform() - 2.5);
  for (const double t : times_s) {
    cv::Mat1b frame(light.size());
    for (int r = 0; r < light.rows; ++r)
      for (int c = 0; c < light.cols; ++c)
        frame(r, c) = cv::saturate_cast<uchar>(255 * std::pow(light(r, c) * t, 1 / 2.2));
    out.frames.push_back(frame);
    out.exposure_s.push_back(t);
  }
  return out;
}

TEST(ResponseCurve, FindsAGammaCurve) {
  const ResponseCurve g = fit_response_curve(synthetic({0.01, 0.04, 0.2, 1, 5, 20}), 1);
  EXPECT_EQ(g[128], 0);
  for (int z = 30; z <= 230; ++z)
    EXPECT_NEAR(g[static_cast<std::size_t>(z)], 2.2 * std::log(z / 128.0), 0.02) << z;
}

TEST(ResponseCurve, MergedLightIsProportionalToTheScene) {
  const EncodedStack stack = synthetic({0.01, 0.04, 0.2, 1, 5, 20});
  const cv::Mat1f light = merge_encoded(stack, fit_response_curve(stack, 1));
  RandomStream random(2, 0);
  double worst = 0;
  const double scale = std::pow(255.0 / 128, 2.2);  // code 128 has exposure 1
  for (const float v : light) {
    const double truth = std::pow(10, 5 * random.uniform() - 2.5);
    if (truth > 0.02 && truth < 50) worst = std::max(worst, std::abs(v / scale / truth - 1));
  }
  EXPECT_LT(worst, 0.06);
}

TEST(ResponseCurve, BadStacksAreRefused) {
  const EncodedStack good = synthetic({0.1, 1});
  EncodedStack bad = good;
  bad.exposure_s = {1, 1};
  EXPECT_THROW(fit_response_curve(bad), ArgumentError);
  bad.exposure_s = {0, 1};
  EXPECT_THROW(fit_response_curve(bad), ArgumentError);
  bad.exposure_s = {1};
  EXPECT_THROW(merge_encoded(bad, {}), ArgumentError);
  bad = good;
  bad.frames[1] = cv::Mat1b(3, 3, uchar{0});
  EXPECT_THROW(merge_encoded(bad, {}), ArgumentError);
  bad.frames = {cv::Mat1b(64, 96, uchar{255}), cv::Mat1b(64, 96, uchar{255})};
  EXPECT_THROW(fit_response_curve(bad), ArgumentError);
}

// The film scans against the radiance map that comes with them, after one global scale.
TEST(ResponseCurve, MemorialChurch) {
  const auto folder = shared_folder("data/exposure_stacks/memorial");
  REQUIRE_SHARED(folder);
  const cv::Mat reference = cv::imread(folder / "memorial.hdr", cv::IMREAD_UNCHANGED);  // B, G, R
  ASSERT_EQ(reference.type(), CV_32FC3);
  std::array<EncodedStack, 3> stacks;
  std::ifstream list(folder / "memorial.txt");
  std::string name;
  for (double per_s = 0; list >> name >> per_s;) {
    if (!std::filesystem::exists(folder / name)) continue;  // held out
    cv::Mat1b planes[3];
    cv::split(read_drive_png(folder / name).codes, planes);
    for (std::size_t k = 0; k < 3; ++k) {
      stacks[k].frames.push_back(planes[k]);
      stacks[k].exposure_s.push_back(1 / per_s);
    }
  }
  ASSERT_EQ(stacks[0].frames.size(), 11u);
  std::array<cv::Mat1f, 3> light;
  for (std::size_t k = 0; k < 3; ++k)
    light[k] = merge_encoded(stacks[k], fit_response_curve(stacks[k]));
  std::vector<double> log_ratio;
  for (int r = 0; r < reference.rows; ++r)
    for (int c = 0; c < reference.cols; ++c)
      for (std::size_t k = 0; k < 3; ++k) {
        int well_exposed = 0;
        for (const cv::Mat1b& frame : stacks[k].frames)
          well_exposed += frame(r, c) > 20 && frame(r, c) < 235;
        const float truth = reference.at<cv::Vec3f>(r, c)[2 - static_cast<int>(k)];
        if (well_exposed >= 2 && truth > 0) log_ratio.push_back(std::log10(light[k](r, c) / truth));
      }
  ASSERT_GT(log_ratio.size(), 500000u);
  const auto median = [](std::vector<double> v) {
    std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
    return v[v.size() / 2];
  };
  const double scale = median(log_ratio);
  for (double& v : log_ratio) v = std::abs(v - scale);
  const double error = median(log_ratio);
  std::cout << "median |log10| error " << error << " over " << log_ratio.size() << " samples\n";
  EXPECT_LE(error, 0.05);
}

}  // namespace
}  // namespace wheatstone
