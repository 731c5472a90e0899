#include "rendering/metrics/ssim.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/error.h"
#include "core/random.h"
#include "photograph.h"
#include "rendering/metrics/pu21.h"
#include "rendering/metrics/row_kernels.h"
#include "tests/shared_data.h"
#include "vectors.h"

namespace wheatstone {
namespace {

using ::testing::HasSubstr;

cv::Mat1d encoded_luminance(const RgbImage& image) {
  cv::Mat1d out(image.height(), image.width());
  for (int r = 0; r < out.rows; ++r)
    for (int c = 0; c < out.cols; ++c) {
      const cv::Vec3f& p = image.pixels(r, c);
      out(r, c) = pu21_encode(kLuminanceWeights[0] * p[0] + kLuminanceWeights[1] * p[1] +
                              kLuminanceWeights[2] * p[2]);
    }
  return out;
}

/// SSIM from its textbook formula, in double: the map, and that of its contrast-structure factor.
struct PlainSsim {
  cv::Mat1d ssim, contrast_structure;
};
PlainSsim plain_ssim(const cv::Mat1d& x, const cv::Mat1d& y) {
  const auto blur = [](const cv::Mat1d& m) {
    cv::Mat1d out;
    cv::GaussianBlur(m, out, {11, 11}, 1.5, 1.5, cv::BORDER_REPLICATE);
    return out;
  };
  constexpr double kC1 = 2.56 * 2.56, kC2 = 7.68 * 7.68;
  const cv::Mat1d mx = blur(x), my = blur(y);
  const cv::Mat1d sxx = blur(x.mul(x)) - mx.mul(mx), syy = blur(y.mul(y)) - my.mul(my),
                  sxy = blur(x.mul(y)) - mx.mul(my);
  PlainSsim out;
  out.contrast_structure = cv::Mat1d(2 * sxy + kC2) / cv::Mat1d(sxx + syy + kC2);
  out.ssim = out.contrast_structure.mul(cv::Mat1d(2 * mx.mul(my) + kC1) /
                                        cv::Mat1d(mx.mul(mx) + my.mul(my) + kC1));
  return out;
}

/// Smooth light over the whole range of PU21 with steps and noise, and a degraded copy: hard for
/// float, since bright and flat places have large means and small variances.
std::pair<RgbImage, RgbImage> hard_pair(int width, int height) {
  RandomStream random(5, 0);
  std::pair<RgbImage, RgbImage> out{RgbImage(width, height), RgbImage(width, height)};
  for (int r = 0; r < height; ++r)
    for (int c = 0; c < width; ++c) {
      const double stops = 20.0 * c / width - 7 + (r / 40 % 2 ? 1 : 0);
      for (int k = 0; k < 3; ++k) {
        const double light = std::exp2(stops) * (1 + 0.002 * random.uniform());
        out.second.pixels(r, c)[k] = static_cast<float>(light);
        out.first.pixels(r, c)[k] = static_cast<float>(light * (1.05 + 0.02 * random.uniform()));
      }
    }
  return out;
}

TEST(Ssim, LikeTheReferenceVectors) {
  int compared = 0;
  const auto file = read_vectors("pu21_metrics.json");
  for (const auto& c : file["cases"]) {
    const std::string test = c["test"], reference = c["reference"];
    EXPECT_NEAR(pu21_ssim_luminance(vector_image(test), vector_image(reference)),
                c["pu_ssim_luminance"].get<double>(), 1e-6)
        << test;
    ++compared;
  }
  EXPECT_EQ(compared, 12);
}

TEST(Ssim, PhotographLikeTheReference) {
  const auto path = shared_folder("reference/metrics/data/nancy_church.hdr");
  REQUIRE_SHARED(path);
  const Photograph photograph = degraded_photograph(path);
  const auto tests = read_vectors("nancy_church.json")["tests"];
  const std::pair<const char*, const RgbImage*> images[] = {{"blur", &photograph.blur},
                                                            {"contrast80", &photograph.contrast80}};
  for (const auto& [name, image] : images) {
    const auto& expected = tests[name];
    const RgbImage& reference = photograph.reference;
    EXPECT_NEAR(pu21_ssim_luminance(*image, reference), expected["pu_ssim_luminance"].get<double>(),
                1e-6);
    EXPECT_NEAR(pu21_psnr_rgb(*image, reference), expected["pu_psnr_rgb_db"].get<double>(), 1e-4);
    EXPECT_NEAR(pu21_psnr_luminance(*image, reference),
                expected["pu_psnr_luminance_db"].get<double>(), 1e-4);
  }
}

TEST(Ssim, EveryPixelOfTheMapIsTheTextbookFormula) {
  for (const cv::Size size : {cv::Size(701, 523), cv::Size(246, 240), cv::Size(3, 2),
                              cv::Size(1, 300), cv::Size(257, 1)}) {
    const auto [test, reference] = hard_pair(size.width, size.height);
    ScalarImage map;
    const double value = pu21_ssim_luminance(test, reference, nullptr, &map);
    const cv::Mat1d exact = plain_ssim(encoded_luminance(test), encoded_luminance(reference)).ssim;
    ASSERT_EQ(map.pixels.size(), size);
    cv::Mat1d difference;
    cv::Mat1d(map.pixels).copyTo(difference);
    EXPECT_LT(cv::norm(difference, exact, cv::NORM_INF), 1e-5);
    EXPECT_NEAR(value, cv::mean(exact)[0], 1e-6);
  }
}

TEST(Ssim, MaskWeighsTheMapAndNotTheWindows) {
  const RgbImage test = vector_image("img/a_patch.pfm"), reference = vector_image("img/a_ref.pfm");
  ScalarImage map;
  pu21_ssim_luminance(test, reference, nullptr, &map);
  cv::Mat1b mask(map.pixels.size(), static_cast<unsigned char>(0));
  mask(cv::Rect(10, 20, 90, 37)) = 1;  // any value but 0 selects
  EXPECT_NEAR(pu21_ssim_luminance(test, reference, &mask), cv::mean(map.pixels, mask)[0], 1e-7);
}

TEST(Ssim, RgbIsTheMeanOfTheChannels) {
  const auto [test, reference] = hard_pair(120, 90);
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    RgbImage a(120, 90), b(120, 90);  // grey pictures of one channel
    for (int r = 0; r < 90; ++r)
      for (int c = 0; c < 120; ++c) {
        a.pixels(r, c) = cv::Vec3f::all(test.pixels(r, c)[k]);
        b.pixels(r, c) = cv::Vec3f::all(reference.pixels(r, c)[k]);
      }
    sum += pu21_ssim_luminance(a, b);
  }
  ScalarImage map;
  EXPECT_NEAR(pu21_ssim_rgb(test, reference, nullptr, &map), sum / 3, 1e-6);
  EXPECT_NEAR(cv::mean(map.pixels)[0], sum / 3, 1e-6);
}

TEST(Ssim, DoesNotDependOnTheThreads) {
  const auto [test, reference] = hard_pair(400, 700);
  const double ssim = pu21_ssim_luminance(test, reference),
               ms_ssim = pu21_ms_ssim_luminance(test, reference);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(pu21_ssim_luminance(test, reference), ssim);
  EXPECT_EQ(pu21_ms_ssim_luminance(test, reference), ms_ssim);
}

TEST(Ssim, WindowsGiveTheSameBitsAtEveryVectorLevel) {
  constexpr int kCount = 101, kWidth = kCount + 10;
  RandomStream random(2, 0);
  std::array<std::array<float, kWidth>, 22> values{};
  std::array<const float*, 11> s{}, d{};
  for (int k = 0; k < 22; ++k) {
    for (float& v : values[k]) v = static_cast<float>(600 * random.uniform());
    (k < 11 ? s[k] : d[k - 11]) = values[k].data();
  }
  const detail::SsimWindow window;
  using Row = std::array<float, kWidth>;
  std::array<Row, 6> first{};
  for (const Simd simd : available_simd()) {
    std::array<Row, 6> rows{};
    const detail::MomentRows moments{rows[0].data(), rows[1].data(), rows[2].data(),
                                     rows[3].data()};
    detail::window_columns(window, s.data(), d.data(), kWidth, moments, simd);
    detail::window_row(window, moments, kCount, rows[4].data(), rows[5].data(), simd);
    if (simd == Simd::kPortable) first = rows;
    EXPECT_EQ(rows, first) << static_cast<int>(simd);
  }
}

/// Half the size by means of 2x2; even sizes only.
cv::Mat1d halved(const cv::Mat1d& m) {
  cv::Mat1d out;
  cv::resize(m, out, m.size() / 2, 0, 0, cv::INTER_AREA);
  return out;
}

TEST(MsSsim, IsTheProductOfItsScales) {
  const RgbImage test = vector_image("img/b_noise05.pfm"),
                 reference = vector_image("img/b_ref.pfm");
  cv::Mat1d x = encoded_luminance(test), y = encoded_luminance(reference);
  double expected = 1;
  for (const double exponent : {0.0448, 0.2856, 0.3001, 0.2363}) {
    expected *= std::pow(cv::mean(plain_ssim(x, y).contrast_structure)[0], exponent);
    x = halved(x);
    y = halved(y);
  }
  expected *= std::pow(cv::mean(plain_ssim(x, y).ssim)[0], 0.1333);
  EXPECT_NEAR(pu21_ms_ssim_luminance(test, reference), expected, 1e-6);
  const cv::Mat1b all = cv::Mat1b::ones(test.pixels.size());
  EXPECT_NEAR(pu21_ms_ssim_luminance(test, reference, &all), expected, 1e-6);
}

TEST(MsSsim, OddSizesRepeatTheirLastRowAndColumn) {
  // A picture whose last row and column are repeated already scores the same after halving; so the
  // two differ only where the finest scale sees the added pixels.
  const auto [test, reference] = hard_pair(255, 255);
  RgbImage test_even, reference_even;
  cv::copyMakeBorder(test.pixels, test_even.pixels, 0, 1, 0, 1, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(reference.pixels, reference_even.pixels, 0, 1, 0, 1, cv::BORDER_REPLICATE);
  EXPECT_NEAR(pu21_ms_ssim_luminance(test, reference),
              pu21_ms_ssim_luminance(test_even, reference_even), 2e-4);
}

TEST(MsSsim, SmallPicturesAreRefused) {
  const auto [test, reference] = hard_pair(175, 300);
  try {
    pu21_ms_ssim_luminance(test, reference);
    FAIL() << "accepted";
  } catch (const ArgumentError& e) {
    EXPECT_THAT(e.what(), HasSubstr("175x300"));
    EXPECT_THAT(e.what(), HasSubstr("176x176"));
  }
  const auto [enough, its_reference] = hard_pair(176, 176);
  EXPECT_LT(pu21_ms_ssim_luminance(enough, its_reference), 1);
}

TEST(Ssim, ImpossiblePicturesAreRefused) {
  using Metric = double (*)(const RgbImage&, const RgbImage&, const cv::Mat1b*);
  const Metric metrics[] = {pu21_psnr_rgb,
                            pu21_psnr_luminance,
                            pu21_ms_ssim_luminance,
                            pu21_ms_ssim_rgb,
                            [](const RgbImage& a, const RgbImage& b, const cv::Mat1b* m) {
                              return pu21_ssim_luminance(a, b, m);
                            },
                            [](const RgbImage& a, const RgbImage& b, const cv::Mat1b* m) {
                              return pu21_ssim_rgb(a, b, m);
                            }};
  const auto [test, reference] = hard_pair(200, 180);
  const auto expect_refused = [&](Metric metric, const RgbImage& a, const RgbImage& b,
                                  const cv::Mat1b* mask, const std::string& part) {
    try {
      metric(a, b, mask);
      ADD_FAILURE() << "accepted: " << part;
    } catch (const ArgumentError& e) {
      EXPECT_THAT(e.what(), HasSubstr(part));
    }
  };
  for (const Metric metric : metrics) {
    expect_refused(metric, RgbImage(), RgbImage(), nullptr, "0x0");
    expect_refused(metric, test, hard_pair(180, 200).second, nullptr, "180x200");
    expect_refused(metric, RgbImage(200, 180), reference, nullptr, "test image is black");
    expect_refused(metric, test, RgbImage(200, 180), nullptr, "reference image is black");
    const cv::Mat1b nothing = cv::Mat1b::zeros(180, 200), wrong = cv::Mat1b::ones(200, 180);
    expect_refused(metric, test, reference, &nothing, "selects no pixel");
    expect_refused(metric, test, reference, &wrong, "the mask has 180x200");
    for (const float bad :
         {-1.0F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
      RgbImage damaged(test.pixels.clone());
      damaged.pixels(7, 11)[2] = damaged.pixels(170, 190)[2] = bad;
      expect_refused(metric, damaged, reference, nullptr, "column 11, row 7");
      expect_refused(metric, damaged, reference, nullptr, "2 ");
      expect_refused(metric, reference, damaged, nullptr, "the reference image");
    }
  }
}

}  // namespace
}  // namespace wheatstone
