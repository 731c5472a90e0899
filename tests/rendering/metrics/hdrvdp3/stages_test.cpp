// Every stage of HDR-VDP-3 against the numbers of the original (hdrvdp3_intermediate.json).

#include <gtest/gtest.h>

#include <cmath>

#include "../vectors.h"
#include "rendering/metrics/hdrvdp3.h"
#include "rendering/metrics/hdrvdp3/eye_optics.h"
#include "rendering/metrics/hdrvdp3/gaussian_blur.h"
#include "rendering/metrics/hdrvdp3/neural_csf.h"
#include "rendering/metrics/hdrvdp3/receptors.h"
#include "rendering/metrics/hdrvdp3/steerable_pyramid.h"
#include "rendering/metrics/hdrvdp3/visual_pathway.h"

namespace wheatstone {
namespace {

// The vectors have 10 to 12 digits; the adaptation's Gaussian is cut where 2e-9 of it are left.
constexpr double kRelative = 1e-8;

const nlohmann::json& vectors() {
  static const nlohmann::json all = read_vectors("hdrvdp3_intermediate.json");
  return all;
}

void expect_close(double value, const nlohmann::json& expected, const std::string& what) {
  const double e = expected;
  EXPECT_NEAR(value, e, kRelative * std::abs(e)) << what;
}

TEST(HdrVdp3Stages, EyeMtf) {
  ASSERT_GE(vectors()["mtf"].size(), 7u);
  for (const auto& row : vectors()["mtf"])
    expect_close(eye_mtf(row["rho_cpd"]), row["mtf"], row.dump());
}

TEST(HdrVdp3Stages, NeuralCsf) {
  ASSERT_GE(vectors()["neural_csf"].size(), 29u);
  for (const auto& row : vectors()["neural_csf"])
    expect_close(neural_csf(row["rho_cpd"], row["L_cd_m2"]), row["sensitivity"], row.dump());
  EXPECT_EQ(neural_csf(0, 100), 0);
}

TEST(HdrVdp3Stages, CsfTableFollowsTheFunction) {
  const LogTable table = neural_csf_table(4);
  for (const double log10_l : {-5.0, -3.3, -1.0, 0.123, 2.0, 5.0})
    EXPECT_NEAR(table(log10_l), neural_csf(4, std::pow(10, log10_l)), 1e-3) << log10_l;
  EXPECT_EQ(table(-9), table(-5));
  EXPECT_EQ(table(9), table(5));
}

TEST(HdrVdp3Stages, ReceptorResponses) {
  ASSERT_GE(vectors()["photoreceptor_jnd"].size(), 7u);
  for (const auto& row : vectors()["photoreceptor_jnd"]) {
    const double excitation = row["log10_retinal_response"];
    expect_close(cone_jnd()(excitation), row["cone_jnd"], row.dump());
    expect_close(rod_jnd()(excitation), row["rod_jnd"], row.dump());
  }
}

TEST(HdrVdp3Stages, PupilDiameter) {
  ASSERT_GE(vectors()["pupil_mm"].size(), 5u);
  for (const auto& row : vectors()["pupil_mm"])
    for (const int age : {24, 28})
      expect_close(pupil_diameter_mm(row["L_cd_m2"], row["area_deg2"], age),
                   row["diameter_age" + std::to_string(age)], row.dump());
  EXPECT_EQ(pupil_diameter_mm(10, 100, 5), pupil_diameter_mm(10, 100, 20));
  EXPECT_EQ(pupil_diameter_mm(10, 100, 99), pupil_diameter_mm(10, 100, 83));
}

TEST(HdrVdp3Stages, ReceptorMatrices) {
  const std::pair<const char*, DisplaySpectra> all[] = {
      {"led-lcd-srgb", DisplaySpectra::kLedLcdSrgb},
      {"led-lcd-wcg", DisplaySpectra::kLedLcdWcg},
      {"oled", DisplaySpectra::kOled}};
  for (const auto& [name, spectra] : all) {
    double l_and_m = 0;
    for (int k = 0; k < 3; ++k) {
      for (int receptor = 0; receptor < 4; ++receptor)
        expect_close(receptor_matrix(spectra)(k, receptor),
                     vectors()["image_to_LMSR_matrices"][name][k][receptor], name);
      l_and_m += receptor_matrix(spectra)(k, 0) + receptor_matrix(spectra)(k, 1);
    }
    EXPECT_NEAR(l_and_m, 1, 1e-9) << name;
  }
}

/// Image a through the pathway at 45 pixels per degree, and blurred (sigma 1 px) through it.
class HdrVdp3Responses : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const RgbImage image = vector_image("img/a_ref.pfm");
    const VisualPathway pathway(image.pixels.size(), 45, DisplaySpectra::kLedLcdSrgb);
    reference = pathway(image);
    test = pathway(blurred(image));
  }
  static RgbImage blurred(const RgbImage& image) {
    std::vector<cv::Mat1f> channels(3);
    cv::split(image.pixels, channels);
    for (cv::Mat1f& channel : channels) {
      cv::Mat1d wide;
      channel.convertTo(wide, CV_64F);
      gaussian_blur(wide, 1, BlurBorder::kReplicate);
      wide.convertTo(channel, CV_32F);  // the original's images are single precision, too
    }
    RgbImage out(image.width(), image.height());
    cv::merge(channels, out.pixels);
    return out;
  }
  static std::vector<cv::Mat1d> bands(const VisualResponse& response) {
    std::vector<cv::Mat1d> out = steerable_bands(response.response_jnd, 4);
    out.back() -= cv::mean(out.back());
    return out;
  }
  static double rms(const cv::Mat1d& m) { return cv::norm(m) / std::sqrt(double(m.total())); }

  static inline VisualResponse reference, test;
};

TEST_F(HdrVdp3Responses, PixelsLikeTheReference) {
  ASSERT_GE(vectors()["pixels"].size(), 4u);
  for (const auto& row : vectors()["pixels"]) {
    const int r = row["row"], c = row["col"];
    expect_close(reference.adaptation_cd_m2(r, c), row["ref_L_adapt"], row.dump());
    expect_close(reference.response_jnd(r, c), row["ref_P"], row.dump());
    expect_close(test.adaptation_cd_m2(r, c), row["test_blur10_L_adapt"], row.dump());
    expect_close(test.response_jnd(r, c), row["test_blur10_P"], row.dump());
  }
}

TEST_F(HdrVdp3Responses, BandsLikeTheReference) {
  ASSERT_EQ(vectors()["bands"].size(), 6u);
  const std::vector<cv::Mat1d> r = bands(reference), t = bands(test);
  for (const auto& row : vectors()["bands"]) {
    const int b = row["band"].get<int>() - 1;
    EXPECT_EQ(r[b].size(), cv::Size(row["cols"], row["rows"]));
    expect_close(band_frequency_cpd(b, 45), row["freq_cpd"], row.dump());
    expect_close(rms(r[b]), row["ref_rms"], row.dump());
    expect_close(rms(t[b]), row["test_blur10_rms"], row.dump());
    expect_close(rms(t[b] - r[b]), row["diff_rms"], row.dump());
    expect_close(cv::norm(r[b], cv::NORM_INF), row["ref_abs_max"], row.dump());
  }
}

}  // namespace
}  // namespace wheatstone
