#include "capture/demosaic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/random.h"

namespace wheatstone {
namespace {

constexpr BayerPattern kPatterns[] = {BayerPattern::kRggb, BayerPattern::kBggr, BayerPattern::kGrbg,
                                      BayerPattern::kGbrg};

LinearMosaic random_mosaic(cv::Size size, BayerPattern pattern, std::uint64_t seed) {
  LinearMosaic out{cv::Mat1f(size), pattern};
  RandomStream random(seed, 1);
  for (float& v : out.values) v = static_cast<float>(random.uniform());
  return out;
}

double worst_difference(const cv::Mat3f& a, const cv::Mat3f& b) {
  return cv::norm(a.reshape(1), b.reshape(1), cv::NORM_INF);
}

TEST(Demosaic, ReferenceVectors) {
  std::ifstream file(WHEATSTONE_SOURCE_DIR "/tests/vectors/hdr/demosaic.json");
  ASSERT_TRUE(file);
  const auto json = nlohmann::json::parse(file);
  int compared = 0;
  for (const auto& v : json["cases"]) {
    LinearMosaic mosaic{cv::Mat1f(v["rows"].get<int>(), v["cols"].get<int>()),
                        bayer_pattern_from_string(v["pattern"])};
    double peak = 0;
    for (int r = 0; r < mosaic.values.rows; ++r)
      for (int c = 0; c < mosaic.values.cols; ++c) {
        mosaic.values(r, c) = v["mosaic"][r][c];
        peak = std::max(peak, std::abs(v["mosaic"][r][c].get<double>()));
      }
    for (const auto& [key, refine] :
         {std::pair("menon2007", true), std::pair("menon2007_without_refinement", false)}) {
      const cv::Mat3f rgb = demosaic(mosaic, refine);
      double worst = 0;
      for (int r = 0; r < rgb.rows; ++r)
        for (int c = 0; c < rgb.cols; ++c)
          for (int k = 0; k < 3; ++k)
            worst = std::max(worst, std::abs(rgb(r, c)[k] - v[key][r][c][k].get<double>()));
      EXPECT_LT(worst, 1e-6 * std::max(1.0, peak)) << v["name"] << " " << key;
      ++compared;
    }
  }
  EXPECT_EQ(compared, 12);
}

TEST(Demosaic, KnownAnswerOfTwoRows) {
  LinearMosaic mosaic{cv::Mat1f(2, 4), BayerPattern::kRggb};
  const float in[2][4] = {{0.30980393f, 0.36078432f, 0.30588236f, 0.3764706f},
                          {0.35686275f, 0.39607844f, 0.36078432f, 0.40000001f}};
  const float first_row[4][3] = {{0.30980393f, 0.35686275f, 0.39215687f},
                                 {0.30980393f, 0.36078432f, 0.39607844f},
                                 {0.30588236f, 0.36078432f, 0.39019608f},
                                 {0.32156864f, 0.3764706f, 0.40000001f}};
  for (int r = 0; r < 2; ++r)
    for (int c = 0; c < 4; ++c) mosaic.values(r, c) = in[r][c];
  const cv::Mat3f rgb = demosaic(mosaic);
  for (int c = 0; c < 4; ++c)
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(rgb(0, c)[k], first_row[c][k], 1e-6) << c << " " << k;
}

// A mosaic that begins one row or column later is the same mosaic of another phase, and mirroring
// preserves phases: away from the cut nothing may change.
TEST(Demosaic, EveryPhaseGivesTheSamePicture) {
  const LinearMosaic whole = random_mosaic({61, 47}, BayerPattern::kRggb, 3);
  const cv::Mat3f rgb = demosaic(whole);
  for (const auto& [pattern, dx, dy] :
       {std::tuple(BayerPattern::kGrbg, 1, 0), std::tuple(BayerPattern::kGbrg, 0, 1),
        std::tuple(BayerPattern::kBggr, 1, 1)}) {
    const cv::Rect cut(dx, dy, 61 - dx, 47 - dy);
    const cv::Mat3f part = demosaic({whole.values(cut), pattern});
    const cv::Rect inside(8, 8, 61 - dx - 8, 47 - dy - 8);
    EXPECT_LT(worst_difference(part(inside), rgb(cut)(inside)), 1e-6) << to_string(pattern);
  }
}

TEST(Demosaic, ConstantsAndMeasuredSamplesStayInEverySize) {
  for (const BayerPattern pattern : kPatterns)
    for (const cv::Size size : {cv::Size(2, 2), cv::Size(3, 2), cv::Size(2, 5), cv::Size(9, 7),
                                cv::Size(1030, 9), cv::Size(7, 530)})
      for (const bool refine : {true, false}) {
        LinearMosaic flat{cv::Mat1f(size), pattern};
        for (int r = 0; r < size.height; ++r)
          for (int c = 0; c < size.width; ++c)
            flat.values(r, c) = static_cast<float>(bayer_colour(pattern, r, c) + 1);
        const cv::Mat3f constant(size, cv::Vec3f(1, 2, 3));
        EXPECT_LT(worst_difference(demosaic(flat, refine), constant), 1e-6);

        const LinearMosaic noise = random_mosaic(size, pattern, 5);
        const cv::Mat3f rgb = demosaic(noise, refine);
        for (int r = 0; r < size.height; ++r)
          for (int c = 0; c < size.width; ++c)
            ASSERT_EQ(rgb(r, c)[bayer_colour(pattern, r, c)], noise.values(r, c));
      }
}

// Several tiles in either direction, any band and any number of threads: the same bits.
TEST(Demosaic, BandsAndThreadsChangeNothing) {
  const LinearMosaic mosaic = random_mosaic({1101, 777}, BayerPattern::kGbrg, 8);
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const cv::Mat3f whole = demosaic(mosaic);
  cv::setNumThreads(7);
  EXPECT_EQ(worst_difference(demosaic(mosaic), whole), 0);
  cv::setNumThreads(threads);
  cv::Mat3f band;
  for (const cv::Range rows : {cv::Range(0, 1), cv::Range(13, 300), cv::Range(771, 777)}) {
    demosaic_rows(mosaic, rows, band);
    EXPECT_EQ(worst_difference(band, whole.rowRange(rows)), 0) << rows.start;
  }
}

TEST(Demosaic, LessThanOneCellIsRefused) {
  EXPECT_THROW(demosaic({cv::Mat1f(1, 4), BayerPattern::kRggb}), ArgumentError);
  EXPECT_THROW(demosaic({cv::Mat1f(4, 1), BayerPattern::kRggb}), ArgumentError);
  EXPECT_THROW(demosaic(LinearMosaic{}), ArgumentError);
}

}  // namespace
}  // namespace wheatstone
